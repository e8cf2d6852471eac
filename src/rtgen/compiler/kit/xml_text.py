"""Prints XML documents."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from itertools import count
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
    named = {**prefixes, **new_prefixes(root, prefixes)}
    body = "\n".join(lines(root, named, declared=named))
    return f"{DECLARATION}{comment}{body}\n"


def new_prefixes(root: XmlElement, in_scope: Mapping[str, str]) -> dict[str, str]:
    """Return prefixes for the namespaces of an element that are not `in_scope`, by namespace."""
    prefixes: dict[str, str] = {}
    taken = {*in_scope.values()}
    free = (name for n in count(1) if (name := f"ns{n}") not in taken)
    for namespace in _namespaces(root):
        if namespace and namespace not in in_scope and namespace not in prefixes:
            prefixes[namespace] = next(free)
    return prefixes


def _namespaces(element: XmlElement) -> Iterator[str]:
    yield element.name[0]
    for namespace, _ in element.attributes:
        yield namespace
    for child in element.children:
        yield from _namespaces(child)


def lines(
    element: XmlElement,
    prefixes: Mapping[str, str],
    *,
    step: str = "    ",
    margin: str = "",
    declared: Mapping[str, str] | None = None,
) -> Iterator[str]:
    """Yield the lines of an element; `prefixes` by namespace, `declared` are those it declares.

    Each level is indented by one `step` more, beginning with `margin`.
    """
    # saxutils imports urllib, which most runs do not need.
    from xml.sax.saxutils import escape, quoteattr

    def qualified(name: tuple[str, str]) -> str:
        namespace, local = name
        return f"{prefixes[namespace]}:{local}" if namespace else local

    name = qualified(element.name)
    attributes = (
        f"{qualified(key)}={quoteattr(value)}"
        for key, value in element.attributes.items()
    )
    declarations = (
        f"xmlns:{prefix}={quoteattr(uri)}" for uri, prefix in (declared or {}).items()
    )
    head = " ".join((name, *attributes, *declarations))
    text = escape(element.text.strip() if element.children else element.text)
    if element.children:
        yield f"{margin}<{head}>{text}"
        for child in element.children:
            yield from lines(child, prefixes, step=step, margin=margin + step)
        yield f"{margin}</{name}>"
    elif text:
        yield f"{margin}<{head}>{text}</{name}>"
    else:
        yield f"{margin}<{head}/>"
