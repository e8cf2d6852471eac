"""Search for included files (ISO C 1998, 16.2): beside the including file, and in folders of -I."""

from __future__ import annotations

import os
from pathlib import Path

from rtgen.compiler.diagnostics import Span
from rtgen.compiler.frontends.idl.rules import lexical
from rtgen.compiler.frontends.idl.text.installed import FILES, PLACES, installed_folder
from rtgen.compiler.frontends.idl.text.source import Library, Source
from rtgen.compiler.frontends.idl.text.unit import Unit
from rtgen.compiler.frontends.kit.library import absolute_path
from rtgen.compiler.frontends.kit.suggestions import Guesses
from rtgen.facts.files import in_folder
from rtgen.facts.idl_files import IDL_SUFFIXES

Folders = tuple[Path | None, ...]
"""Folders of `-I` to search; None: the folder of the including file."""

Place = tuple[Path | None, Folders, str]
"""The folder of the including file if it is searched, the other folders, and the file's name."""


class IncludePath:
    """Finds the files of a library; a missing file is reported with a hint.

    Diagnostics and the searched paths are recorded in the unit that includes the file.
    """

    def __init__(self, library: Library) -> None:
        self._library = library
        self.known: dict[Place, tuple[Source, tuple[str, ...], bool]] = {}
        """By place, the file, the paths that were searched, and whether it is on no disk."""
        self._missing: dict[Place, str] = {}
        self._origins: dict[Source, Path | None] = {}
        self._searched: dict[tuple[Path | None, Folders], tuple[str, list[str]]] = {}
        self._installed: set[Source] = set()
        """The files found in the folder of OpenRTM."""
        self._guesses = Guesses()

    def place(
        self, includer: Source, name: str, *, quoted: bool, further: bool
    ) -> Place:
        """Return the place that an `#include` in a file names.

        `further`: search only the folders after that of the file, as GNU's `#include_next` does.
        """
        folders: Folders = (None, *self._library.include)
        origin = self._origins.get(includer)
        if further and origin is not None:
            folders = folders[folders.index(origin) + 1 :]
        elif not quoted or includer in self._installed:
            # A file of OpenRTM includes rtgen's files of OpenRTM's types, not those beside it.
            folders = folders[1:]
        return (includer.folder if None in folders else None, folders, name)

    def find(self, place: Place, span: Span, unit: Unit) -> Source | None:
        """Return the file at a place; None, after a diagnostic, if there is none."""
        cached = self.known.get(place)
        if cached is None:
            source, searched, printed = self._search(place, span, unit)
            if source is not None:
                self.known[place] = source, searched, printed
        else:
            source, searched, printed = cached
        unit.searched.update(dict.fromkeys(searched))
        if printed:
            unit.printed[place[-1]] = None
        return source

    def _search(
        self, place: Place, span: Span, unit: Unit
    ) -> tuple[Source | None, tuple[str, ...], bool]:
        """Return the file, the paths that were searched, and whether the file is on no disk."""
        beside, folders, name = place
        searched: list[str] = []
        if place not in self._missing:
            try:
                for folder in folders:
                    where = folder or beside or ""
                    path = os.path.join(where, name)  # noqa: PTH118 (time)
                    searched.append(absolute_path(path))
                    interface = self._library.interface(path, folder)
                    if interface is not None:
                        source, printed = interface
                        searched += (str(each.path) for each in printed.dependencies)
                        for each in printed.findings:
                            unit.findings.report(each)
                        if printed.findings:
                            unit.guessed = True
                            return None, (), False
                        self._origins.setdefault(source, folder)
                        return source, tuple(searched), False
                    candidate = self._library.open(path, folder)
                    if candidate is not None:
                        self._origins.setdefault(candidate, folder)
                        return candidate, tuple(searched), False
                if (virtual := self._library.virtual(name)) is not None:
                    return virtual, tuple(searched), True
                if (installed := self._of_openrtm(name, searched)) is not None:
                    return installed, tuple(searched), False
                if (inner := self._in_idl_folder(place, searched)) is not None:
                    return inner, tuple(searched), False
            except (OSError, ValueError) as error:
                reason = getattr(error, "strerror", None) or error
                message = f"{name} cannot be read: {reason}"
                unit.findings.report(lexical.UNREADABLE.at(span, message))
                unit.guessed = True
                return None, (), False
            self._missing[place] = self._hint(place)
        unit.guessed = True
        unit.findings.report(
            lexical.INCLUDE_NOT_FOUND.at(
                span, f"the file {name} was not found", hint=self._missing[place]
            )
        )
        return None, (), False

    def _of_openrtm(self, name: str, searched: list[str]) -> Source | None:
        """Return the file of this name that OpenRTM has installed."""
        folder = installed_folder()
        if folder is None or Path(name).name != name:
            return None
        path = folder / name
        searched.append(absolute_path(path))
        source = self._library.open(path, folder)
        if source is not None:
            self._installed.add(source)
        return source

    def _in_idl_folder(self, place: Place, searched: list[str]) -> Source | None:
        """Return the file in a folder `idl` beside the one that includes it, as of RTCBuilder."""
        beside, _, name = place
        if beside is None or ".." in Path(name).parts:
            return None
        path = beside / "idl" / name
        searched.append(absolute_path(path))
        return self._library.open(path)

    def _hint(self, place: Place) -> str:
        """Return a hint: the folders searched, and a file there with a similar name."""
        beside, folders, name = place
        if name in FILES:
            return f"OpenRTM installs it; its folder of IDL files is asked of {PLACES}"
        if (beside, folders) not in self._searched:
            real = [folder or beside or Path() for folder in folders]
            shown = dict.fromkeys(map(self._library.displayed, real))
            files = [p.name for folder in real for p in in_folder(folder, IDL_SUFFIXES)]
            places = ", ".join(shown) or "no folder (use -I)"
            files += self._library.virtual_names
            self._searched[beside, folders] = places, files
        places, files = self._searched[beside, folders]
        last = Path(name).name
        near = self._guesses.nearest(last, files)
        if near is None:
            return f"searched: {places}"
        case = " (only the case differs)" if near.lower() == last.lower() else ""
        return f"did you mean {near}?{case} searched: {places}"
