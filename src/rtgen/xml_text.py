"""Prints XML documents."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Protocol

DECLARATION = '<?xml version="1.0" encoding="UTF-8" standalone="yes"?>\n'

NOT_IN_XML = re.compile("[\0-\b\v\f\x0e-\x1f\ud800-\udfff\ufffe\uffff]")
"""Characters that XML 1.0 cannot represent, not even as references."""


class XmlElement(Protocol):
    """An element to print; names are `(namespace, local name)`."""

    @property
    def name(self) -> tuple[str, str]: ...
    @property
    def attributes(self) -> Mapping[tuple[str, str], str]: ...
    @property
    def children(self) -> Sequence[XmlElement]: ...
    @property
    def text(self) -> str: ...


def document(root: XmlElement, prefixes: Mapping[str, str], comment: str = "") -> str:
    """Return a document as text; `prefixes` by namespace. Other namespaces get `ns1`, `ns2` and so
    on.

    `comment` is placed before the root.
    """
    from xml.sax.saxutils import quoteattr

    named = dict(prefixes)
    for namespace in _namespaces(root):
        if namespace and namespace not in named:
            named[namespace] = f"ns{len(named) - len(prefixes) + 1}"
    declared = [f"xmlns:{prefix}={quoteattr(uri)}" for uri, prefix in named.items()]
    body = "\n".join(_lines(named, root, 0, declared))
    return f"{DECLARATION}{comment}{body}\n"


def _namespaces(element: XmlElement) -> Iterator[str]:
    yield element.name[0]
    for namespace, _ in element.attributes:
        yield namespace
    for child in element.children:
        yield from _namespaces(child)


def _lines(
    prefixes: Mapping[str, str],
    element: XmlElement,
    depth: int,
    declared: Iterable[str] = (),
) -> Iterator[str]:
    # saxutils imports urllib, which most runs do not need.
    from xml.sax.saxutils import escape, quoteattr

    def qualified(name: tuple[str, str]) -> str:
        namespace, local = name
        return f"{prefixes[namespace]}:{local}" if namespace else local

    margin, name = "    " * depth, qualified(element.name)
    attributes = (
        f"{qualified(key)}={quoteattr(value)}"
        for key, value in element.attributes.items()
    )
    head = " ".join((name, *attributes, *declared))
    text = escape(element.text.strip() if element.children else element.text)
    if element.children:
        yield f"{margin}<{head}>{text}"
        for child in element.children:
            yield from _lines(prefixes, child, depth + 1)
        yield f"{margin}</{name}>"
    elif text:
        yield f"{margin}<{head}>{text}</{name}>"
    else:
        yield f"{margin}<{head}/>"
