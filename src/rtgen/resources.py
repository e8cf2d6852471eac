"""Files that ship with rtgen: found inside the installed package or beside the source tree."""

from __future__ import annotations

from functools import cache
from pathlib import Path

_PACKAGE = Path(__file__).resolve().parent
_FOLDERS = (_PACKAGE / "grammars", _PACKAGE.parents[1] / "grammars")


@cache
def grammar(name: str) -> str:
    """The text of a grammar, by its file name (`idl.lark`); FileNotFoundError if there is none."""
    for folder in _FOLDERS:
        path = folder / name
        if path.is_file():
            return path.read_text(encoding="utf-8")
    raise FileNotFoundError(f"the grammar {name} is missing from this installation")
