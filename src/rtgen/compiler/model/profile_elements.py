"""XML elements of a profile that rtgen keeps without interpreting them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TypeAlias

import msgspec

RTS = "http://www.openrtp.org/namespaces/rts"
RTS_EXT = "http://www.openrtp.org/namespaces/rts_ext"
XSI = "http://www.w3.org/2001/XMLSchema-instance"

Name: TypeAlias = tuple[str, str]
"""Namespace and local name of an element or attribute."""


class ProfileElement(msgspec.Struct, frozen=True, kw_only=True):
    """An element with its attributes, children, and the text directly inside."""

    name: Name
    attributes: Mapping[Name, str] = msgspec.field(default_factory=dict)
    children: tuple[ProfileElement, ...] = ()
    text: str = ""

    def get(self, namespace: str, local_name: str) -> str:
        """Return an attribute's value, empty if it is missing."""
        return self.attributes.get((namespace, local_name), "")

    def all(self, local_name: str) -> Iterator[ProfileElement]:
        """Return the children of that local name, in order."""
        return (child for child in self.children if child.name[1] == local_name)
