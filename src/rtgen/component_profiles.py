"""RtcProfiles of a project: the IDL files that they need, and their components."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from rtgen.frontends import FrontendResult, rtc_profile
from rtgen.frontends.kit.library import VirtualFile
from rtgen.frontends.rtc_profile import Profiles
from rtgen.standard_idl import standard_idl

_DECLARED = re.compile(r"\b(?:struct|union|interface)\s+(\w+)\s*[:{]")


@dataclass(frozen=True, slots=True)
class ProfileIdl:
    """The IDL that profiles depend on: files that they name, and the types of OpenRTM."""

    profiles: Profiles
    paths: tuple[Path, ...]
    virtual: dict[str, VirtualFile | Path] = field(default_factory=dict)
    given: frozenset[str] = frozenset()

    def results(self, found: FrontendResult) -> list[FrontendResult]:
        """The results for the IDL files, without components of profiles, and for the profiles."""
        made = rtc_profile.lowered(self.profiles, found.model, self.given)
        names = {each.name for each in made.model.declarations}
        rest = (each for each in found.model.declarations if each.name not in names)
        return [
            replace(found, model=replace(found.model, declarations=tuple(rest))),
            made,
        ]


def read(
    paths: Sequence[Path],
    definitions: Sequence[Path],
    *,
    root: Path,
    include: Sequence[Path],
) -> ProfileIdl:
    """Read profiles; `definitions` are the project's IDL files."""
    return needed(rtc_profile.read(paths, root=root, include=include), definitions)


def needed(profiles: Profiles, definitions: Sequence[Path]) -> ProfileIdl:
    """The IDL that profiles depend on.

    A type of OpenRTM comes from the project's file of that name, else from the one that ships
    with rtgen.
    """
    known = {path.resolve() for path in definitions}
    further = tuple(p for p in profiles.idl if p.resolve() not in known)
    names = _openrtm_names(profiles)
    virtual = {
        name: (
            replace(file, given=not names.isdisjoint(_DECLARED.findall(file.text)))
            if isinstance(file, VirtualFile)
            else file
        )
        for name, file in standard_idl((*definitions, *further)).items()
    }
    chosen = frozenset(path.as_posix() for path in definitions)
    return ProfileIdl(profiles, further, virtual, chosen)


def type_names(profiles: Profiles) -> set[str]:
    """The last parts of the types of all ports."""
    types = [port.type for p in profiles.profiles for port in p.data_ports]
    types += [
        each.type
        for p in profiles.profiles
        for service in p.service_ports
        for each in service.interfaces
    ]
    return {type_.replace(".", "::").split("::")[-1] for type_ in types}


def declared_in(path: Path) -> set[str]:
    """The structs, unions and interfaces that an IDL file likely declares; none if unreadable."""
    try:
        return set(_DECLARED.findall(path.read_text("utf-8", "replace")))
    except OSError:
        return set()


def _openrtm_names(profiles: Profiles) -> set[str]:
    """The last parts of the types of all ports that may be OpenRTM's."""
    types = [port.type for p in profiles.profiles for port in p.data_ports]
    parts = [type_.split("::") for type_ in types]
    return {part[-1] for part in parts if len(part) == 1 or part[-2] == "RTC"}
