"""Files that ship with rtgen: found inside the installed package or beside the source tree."""

from __future__ import annotations

from pathlib import Path

_PACKAGE = Path(__file__).resolve().parent
_FOLDERS = (_PACKAGE / "grammars", _PACKAGE.parents[1] / "grammars")

_IDL = (_PACKAGE / "idl", _PACKAGE.parents[1] / "specs" / "idl")


def grammar_file(name: str) -> Path:
    """The path of a grammar (`idl.lark`); FileNotFoundError if there is none."""
    return _found(name, _FOLDERS)


def idl_file(name: str) -> Path:
    """The path of an IDL file that ships with rtgen (`Canopen.idl`); FileNotFoundError."""
    return _found(name, _IDL)


def _found(name: str, folders: tuple[Path, ...]) -> Path:
    for folder in folders:
        path = folder / name
        if path.is_file():
            return path
    raise FileNotFoundError(f"{name} is missing from this installation")
