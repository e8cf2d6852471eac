"""Files that ship with rtgen: found inside the installed package or beside the source tree."""

from __future__ import annotations

from pathlib import Path

_PACKAGE = Path(__file__).resolve().parent
_FOLDERS = (_PACKAGE / "grammars", _PACKAGE.parents[1] / "grammars")


def grammar_file(name: str) -> Path:
    """The path of a grammar (`idl.lark`); FileNotFoundError if there is none."""
    for folder in _FOLDERS:
        path = folder / name
        if path.is_file():
            return path
    raise FileNotFoundError(f"the grammar {name} is missing from this installation")
