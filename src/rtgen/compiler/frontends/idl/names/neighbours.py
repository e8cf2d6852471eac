"""Searches nearby files for declarations of an unknown name, for hints only."""

from __future__ import annotations

import re
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
    """Index of the declarations in the files beside a unit and in the include folders."""

    def __init__(self, library: Library) -> None:
        self._library = library
        self._names_of: dict[Path, dict[str, str]] = {}

    def declares(self, name: str, unit: Unit) -> str | None:
        """Return how to include the file that declares a name; None if there is none."""
        own = unit.source.path.parent
        for folder in (own, *self._library.include):
            file = self._names(folder).get(name)
            if file is not None and file != unit.source.path.name:
                return file
        return None

    def _names(self, folder: Path) -> dict[str, str]:
        if folder not in self._names_of:
            names: dict[str, str] = {}
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
                for match in _DECLARED.finditer(decode(data, encoding).text):
                    names.setdefault(match[1] or match[2], path.name)
                if remaining <= 0:
                    break
            self._names_of[folder] = names
        return self._names_of[folder]
