"""The IDL files of rtgen that profiles require."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from pathlib import Path

from rtgen.facts.encodings import decode
from rtgen.files import read_file
from rtgen.model.rtc_profile import RtcProfile
from rtgen.resources import IDL_FILES, OPENRTM_IDL, idl_source

_DECLARED = re.compile(r"\b(?:struct|union|interface)\s+(\w+)\s*[:{]")


def needed_idl(profiles: Sequence[RtcProfile]) -> list[str]:
    """Return the names of the files in profiles, or with OpenRTM's types of data ports."""
    types = [port.type for profile in profiles for port in profile.data_ports]
    parts = [type_.split("::") for type_ in types]
    names = {p[-1] for p in parts if len(p) == 1 or p[-2] == "RTC"}
    needed = {file for profile in profiles for file in _files(profile)}
    if names:
        needed.update(
            file
            for file in OPENRTM_IDL
            if not names.isdisjoint(_DECLARED.findall(idl_source(file)))
        )
    return [file for file in IDL_FILES if file in needed]


def _files(profile: RtcProfile) -> Iterator[str]:
    yield from (port.idl_file for port in profile.data_ports)
    for service in profile.service_ports:
        yield from (each.idl_file for each in service.interfaces)


def type_names(profile: RtcProfile) -> set[str]:
    """Return the last parts of the types of all ports."""
    return {type_.replace(".", "::").split("::")[-1] for type_ in _types(profile)}


def _types(profile: RtcProfile) -> Iterator[str]:
    yield from (port.type for port in profile.data_ports)
    for service in profile.service_ports:
        yield from (each.type for each in service.interfaces)


def declared_in(path: Path) -> set[str]:
    """Return the types and interfaces that an IDL file likely declares; none if unreadable."""
    try:
        return set(_DECLARED.findall(decode(read_file(path)).text))
    except OSError:
        return set()
