"""Elements of descriptions in XML, by their local names in the namespaces of CiA 311."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence

from rtgen.compiler.frontends.eds.findings import Findings
from rtgen.compiler.frontends.eds.rules import xml as rules
from rtgen.compiler.frontends.kit.located_xml import Element
from rtgen.compiler.typemap.canopen.xdd import NAMESPACES

_LINE_ENDS = re.compile(r"[^\S\r\n]*[\r\n\v\f\x1c-\x1e\x85\u2028\u2029]\s*")


def line(text: str) -> str:
    """Return a text as one line, without white space around it."""
    return _LINE_ENDS.sub(" ", text.strip())


class Elements:
    """Finds elements; some schemas qualify local names, others do not.

    An element of another namespace is taken, with a warning for each namespace, if there is none.
    """

    def __init__(self, findings: Findings, root: str) -> None:
        self._findings = findings
        self._usual = {"", root, *NAMESPACES}
        self._warned: set[str] = set()

    def warn(self, element: Element) -> None:
        """Warn of the namespace of an element, once."""
        namespace, name = element.name
        if namespace not in self._warned:
            self._warned.add(namespace)
            what = f"the namespace {namespace[:80]!r}" if namespace else "no namespace"
            message = f"{name} has {what}; it is read as one of CiA 311"
            hint = f"write xmlns={NAMESPACES[0]!r}"
            self._findings.add(rules.NAMESPACE, element.span, message, hint=hint)

    def all(self, parent: Element | None, name: str) -> Iterator[Element]:
        """Yield the children of a name, in order; none without a parent."""
        named = [] if parent is None else _named(parent, name)
        usual = [each for each in named if each.name[0] in self._usual]
        if named and not usual:
            self.warn(named[0])
        yield from usual or named

    def first(self, parent: Element | None, name: str) -> Element | None:
        """Return the first child of a name."""
        return next(self.all(parent, name), None)

    def has(self, parent: Element, name: str) -> bool:
        """Return whether there is a child of a name, in any namespace."""
        return bool(_named(parent, name))

    def at(self, parent: Element | None, path: Sequence[str]) -> Element | None:
        """Return the first element on a path of names."""
        for name in path:
            parent = self.first(parent, name)
        return parent

    def text(self, parent: Element | None, kind: str = "label") -> str:
        """Return the text of a label or description: the English one, or else the first."""
        labels = list(self.all(parent, kind))
        english = [e for e in labels if e.get("", "lang").lower().startswith("en")]
        chosen = (english or labels)[:1]
        return line(chosen[0].text) if chosen else ""


def _named(parent: Element, name: str) -> list[Element]:
    return [child for child in parent.children if child.name[1] == name]
