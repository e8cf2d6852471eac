"""Searches for the IDL files that a profile needs: by the names it has for them, else by its types.

RTCBuilder writes no file names, or paths of another machine, and finds types by their names.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from hashlib import sha256
from pathlib import Path, PureWindowsPath
from typing import Final

from rtgen.compiler.frontends import Dependency
from rtgen.compiler.frontends.idl.text.installed import installed_folder
from rtgen.compiler.frontends.kit.library import MAX_BYTES
from rtgen.compiler.kit.resources import IDL_FILES, idl_source
from rtgen.compiler.model.rtc_profile import RtcProfile
from rtgen.facts.encodings import decode
from rtgen.facts.files import in_folder, is_file, read_start
from rtgen.facts.idl_declarations import declared
from rtgen.facts.idl_files import IDL_SUFFIXES

_MAX_FILES: Final = 200
"""Maximum number of files of a folder that are searched."""
_MAX_BYTES: Final = 16_000_000
"""Maximum number of octets that are searched for the types of a profile."""


def candidates(
    path: Path, root: Path, include: Sequence[Path], sources: Sequence[Path]
) -> list[Path]:
    """Return the IDL files in which the types of a profile are searched, in order.

    They are the `sources` of the project, those beside the profile and in a folder `idl` there, in
    the project's folder `idl`, in the include folders, and of OpenRTM.
    """
    files = [each for each in sources if each.suffix.lower() in IDL_SUFFIXES]
    for folder in _folders(path, root, include):
        try:
            files += in_folder(folder, IDL_SUFFIXES)[:_MAX_FILES]
        except OSError:
            continue
    return list(dict.fromkeys(files))


def _folders(path: Path, root: Path, include: Sequence[Path]) -> Iterator[Path]:
    yield from dict.fromkeys((path.parent, path.parent / "idl", root / "idl", *include))
    installed = installed_folder()
    if installed is not None:
        yield installed


class Search:
    """The search for the IDL files of one profile; `dependencies` are the paths searched."""

    def __init__(
        self, path: Path, root: Path, include: Sequence[Path], sources: Sequence[Path]
    ) -> None:
        self.dependencies: list[Dependency] = []
        self._folders = list(_folders(path, root, include))
        self._place = path, root, include, sources

    def files(self, profile: RtcProfile) -> list[Path]:
        """Return the files, each once."""
        paths: dict[Path, None] = {}
        missing: dict[str, None] = {}
        by_name: dict[str, Path | None] = {}
        for file, type_ in _needs(profile):
            name = PureWindowsPath(file.strip()).name
            if name not in by_name:
                by_name[name] = self._named(name)
            there = by_name[name]
            if there is not None:
                paths[there] = None
            elif name not in IDL_FILES and type_:
                missing[type_] = None
        if missing:
            paths |= dict.fromkeys(self._declaring(list(missing)))
        return list(paths)

    def _named(self, name: str) -> Path | None:
        if not name.lower().endswith(IDL_SUFFIXES):
            return None
        for folder in self._folders:
            candidate = folder / name
            if self._note(candidate) is not None:
                return candidate
        return None

    def _declaring(self, types: Sequence[str]) -> Iterator[Path]:
        """Yield the first file that declares each type; OpenRTM's are known without."""
        stock = [declared(idl_source(name)) for name in IDL_FILES]
        remaining = {t for t in types if not any(each.has(t) for each in stock)}
        budget = _MAX_BYTES
        for path in candidates(*self._place) if remaining else ():
            data = self._note(path)
            budget -= len(data or b"")
            here = declared(decode(data or b"").text)
            hits = {type_ for type_ in remaining if here.has(type_)}
            if hits:
                yield path
            remaining -= hits
            if not remaining or budget <= 0:
                return

    def _note(self, path: Path) -> bytes | None:
        """Record a path that was searched for; return its content, None if it is missing."""
        data = _read(path)
        digest = None if data is None else sha256(data).hexdigest()
        self.dependencies.append(Dependency(path, digest))
        return data


def _needs(profile: RtcProfile) -> Iterator[tuple[str, str]]:
    """Yield the IDL files that a profile names, each with the type it is named for."""
    for port in profile.data_ports:
        yield port.idl_file, port.data_type
    for service in profile.service_ports:
        for interface in service.interfaces:
            yield interface.idl_file, interface.type
    files = profile.facts.get("files") or ()
    yield from ((file, "") for file in files if isinstance(file, str))


def _read(path: Path) -> bytes | None:
    try:
        return read_start(path, MAX_BYTES + 1) if is_file(path) else None
    except OSError:  # its name is too long, for example
        return None
