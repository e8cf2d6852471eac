"""Python names for names of a definition (PEP 8 for names chosen by rtgen)."""

from __future__ import annotations

import keyword
import re
import unicodedata
from collections.abc import Collection
from functools import lru_cache

from rtgen.facts import python_modules

_WHOLE_WORD = re.compile(r"CANopen|CiA(?![a-z])|[A-Z]{2,}s(?![a-z])")
"""Words whose capitals do not begin others: names of the field, plurals of acronyms."""
_WORD_END = re.compile(r"([A-Z]+)([A-Z][a-z])")
_WORD_START = re.compile(r"([a-z0-9])([A-Z])")
_NOT_A_WORD = re.compile(r"\W")
_CHECKING = "TYPE_CHECKING"
"""A name that type checkers take for a constant of theirs, wherever it is defined."""
_MODULES_OF_PYTHON = ("__init__", "__main__")


def identifier(name: str, reserved: Collection[str] = ()) -> str:
    """Return the name as a Python identifier; `_` is appended to keywords and reserved names.

    It is in Python's normal form of identifiers (NFKC), so that attribute access by text works.
    """
    name = _plain(name)
    while name in reserved:
        name += "_"
    return name


@lru_cache(maxsize=16384)
def _plain(name: str) -> str:
    """Return the name as an identifier that is not a keyword."""
    name = words(name)
    if not name.isidentifier():
        name = f"o_{name}"
    while keyword.iskeyword(name) or name == _CHECKING:
        name += "_"
    return name


def words(name: str) -> str:
    """Return the normal form of a name, with `_` for illegal characters."""
    if name.isascii():
        return name if name.isidentifier() else _NOT_A_WORD.sub("_", name)
    name = unicodedata.normalize("NFKC", name)
    return "".join(c if f"_{c}".isidentifier() else "_" for c in name)


def snake_case(name: str) -> str:
    """Convert to snake case: `RefHardRh3` to `ref_hard_rh3`, `OmniTo2WD` to `omni_to2_wd`.

    `CANopenPDOs` becomes `canopen_pdos`; else the words are those of rosidl's names of files.
    """
    name = _WHOLE_WORD.sub(lambda found: found[0].capitalize(), name)
    name = _WORD_END.sub(r"\1_\2", name)
    return _WORD_START.sub(r"\1_\2", name).lower()


def module_name(name: str) -> str:
    """Return the module or package generated for a file's stem or a component."""
    return identifier(snake_case(words(name)), _MODULES_OF_PYTHON)


def skeleton_module(name: str, package: str, skeleton_package: str) -> str:
    """Return the absolute name of the module of a component's skeleton.

    One at the top level (empty `skeleton_package`) gets a `_` if it would hide a module of Python,
    of rtgen or of its requirements, or the generated `package`.
    """
    module = module_name(name)
    if skeleton_package:
        return f"{skeleton_package}.{module}"
    root = package.partition(".")[0]
    while module == root or python_modules.owner(module):
        module += "_"
    return module
