"""Files that ship with rtgen: found inside the installed package or beside the source tree."""

from __future__ import annotations

from pathlib import Path

_PACKAGE = Path(__file__).resolve().parent
_FOLDERS = (_PACKAGE / "grammars", _PACKAGE.parents[1] / "grammars")

OPENRTM_IDL = (
    *("BasicDataType.idl", "ExtendedDataTypes.idl", "InterfaceDataTypes.idl"),
)
"""OpenRTM's data types, each file including those before it."""

IDL_FILES = (*OPENRTM_IDL, "Canopen.idl", "CanopenManager.idl")
"""The IDL files that definitions may include without having them."""

_IDL = (_PACKAGE / "idl", _PACKAGE.parents[1] / "specs" / "idl")


def grammar_file(name: str) -> Path:
    """The path of a grammar (`idl.lark`); FileNotFoundError if there is none."""
    return _found(name, _FOLDERS)


def idl_file(name: str) -> Path:
    """The path of an IDL file that ships with rtgen (`Canopen.idl`); FileNotFoundError."""
    return _found(name, _IDL)


def idl_source(name: str) -> str:
    """The text of an IDL file that ships with rtgen; FileNotFoundError."""
    return idl_file(name).read_text("utf-8")


def _found(name: str, folders: tuple[Path, ...]) -> Path:
    for folder in folders:
        path = folder / name
        if path.is_file():
            return path
    raise FileNotFoundError(f"{name} is missing from this installation")
