"""The IDL files of rtgen that profiles require."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from rtgen.compiler.kit.resources import IDL_FILES, OPENRTM_IDL, idl_source
from rtgen.compiler.model.rtc_profile import RtcProfile
from rtgen.facts.idl_declarations import declared


def needed_idl(profiles: Sequence[RtcProfile]) -> list[str]:
    """Return the names of the files in profiles, or with OpenRTM's types of data ports."""
    types = [port.data_type for profile in profiles for port in profile.data_ports]
    parts = [type_.split("::") for type_ in types]
    names = {p[-1] for p in parts if len(p) == 1 or p[-2] == "RTC"}
    needed = {file for profile in profiles for file in _files(profile)}
    if names:
        needed.update(
            file
            for file in OPENRTM_IDL
            if not names.isdisjoint(declared(idl_source(file)).types)
        )
    return [file for file in IDL_FILES if file in needed]


def _files(profile: RtcProfile) -> Iterator[str]:
    yield from (port.idl_file for port in profile.data_ports)
    for service in profile.service_ports:
        yield from (each.idl_file for each in service.interfaces)
