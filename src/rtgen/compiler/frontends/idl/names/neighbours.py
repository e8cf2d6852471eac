"""Searches nearby files for declarations of an unknown name, for hints only."""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path

from rtgen.compiler.frontends.idl.text.source import Library
from rtgen.compiler.frontends.idl.text.unit import Unit
from rtgen.facts import files
from rtgen.facts.encodings import decode
from rtgen.facts.idl_files import IDL_SUFFIXES

_MAX_FILES = 200
_MAX_BYTES = 4_000_000
_DECLARED = re.compile(
    r"^[ \t]*(?:abstract\s+|local\s+)?"
    r"(?:struct|union|enum|interface|module|exception|valuetype|bitmask|bitset)\s+(\w+)\s*"
    r"(?:[{:]|switch\b)|^[ \t]*(?:typedef|const)\b[^;{]{0,300}?\b(\w+)(?:\[[^;]{0,80}\])?"
    r"\s*(?:=[^;]{0,300})?;",
    re.MULTILINE,
)


class Neighbours:
    """Index of the declarations of files that a unit may include.

    They are those beside it, those in the include folders, and those that ship with rtgen.
    """

    def __init__(self, library: Library) -> None:
        self._library = library
        self._names_in: dict[Path, dict[str, set[str]]] = {}

    def declares(self, names: Iterable[str], unit: Unit) -> str | None:
        """Return how to include the file that declares all of the names; None if there is none."""
        wanted = set(names)
        for folder in (unit.source.path.parent, *self._library.include):
            for file, declared in self._names(folder).items():
                if wanted <= declared and file != unit.source.path.name:
                    return file
        for file, text in self._library.virtual_texts():
            if wanted <= _declared(text):
                return file
        return None

    def _names(self, folder: Path) -> dict[str, set[str]]:
        """Return the names that are declared in each file of a folder."""
        if folder not in self._names_in:
            names: dict[str, set[str]] = {}
            encoding = self._library.encoding
            remaining = _MAX_BYTES
            for path in files.in_folder(folder, IDL_SUFFIXES)[:_MAX_FILES]:
                try:
                    if not files.is_file(path):
                        continue
                    data = files.read_start(path, remaining)
                except OSError:
                    continue
                remaining -= len(data)
                names[path.name] = _declared(decode(data, encoding).text)
                if remaining <= 0:
                    break
            self._names_in[folder] = names
        return self._names_in[folder]


def _declared(text: str) -> set[str]:
    return {match[1] or match[2] for match in _DECLARED.finditer(text)}
