"""Prints systems as RtsProfile: the XML of RT System Editor and rtshell, format version 0.2.

Further content of the system's file is preserved (`kept`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from rtgen.compiler.backends.kit.quoting.code import UnquotableError
from rtgen.compiler.backends.kit.quoting.xml import xml_comment
from rtgen.compiler.backends.profiles.rts_profile.elements import (
    InstancePorts,
    profile_element,
)
from rtgen.compiler.backends.profiles.rts_profile.kept import with_kept
from rtgen.compiler.kit import xml_text
from rtgen.compiler.model import System
from rtgen.compiler.model.profile_elements import RTS, RTS_EXT, XSI

_PREFIXES = {RTS: "rts", RTS_EXT: "rtsExt", XSI: "xsi"}

__all__ = ["InstancePorts", "system_text"]


def system_text(
    system: System,
    ports: Mapping[str, InstancePorts] | None = None,
    header: Sequence[str] = (),
) -> str:
    """Return the system as XML; `ports` by instance, by default the connected ones.

    Connectors and components keep the order of the system. The activation order is written
    separately; several steps of an instance follow it. Raises UnquotableError for characters that
    XML cannot represent.
    """
    root = profile_element(system, ports)
    if system.document is not None:
        root = with_kept(root, system.document, all_ports=ports is not None)
    lines = (f"  {xml_comment(line)}".rstrip() for line in header)
    comment = "\n".join(("<!--", *lines, "-->", "")) if header else ""
    text = xml_text.document(root, _PREFIXES, comment)
    if xml_text.NOT_IN_XML.search(text):
        raise UnquotableError(system.name, "XML")
    return text
