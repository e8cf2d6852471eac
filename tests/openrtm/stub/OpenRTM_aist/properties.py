"""Trees of texts: profiles, configuration files, settings of connectors."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator


class Properties:
    """A node has a text and named nodes below it; a key joins names with dots."""

    def __init__(
        self,
        prop: Properties | None = None,
        key: str = "",
        value: str = "",
        defaults_str: Iterable[str] | None = None,
    ) -> None:
        self.name = key
        self.value = value
        self.leaf: dict[str, Properties] = {}
        if prop is not None:
            self.name, self.value = prop.name, prop.value
            self.mergeProperties(prop)
        if defaults_str is not None:
            self.setDefaults(defaults_str)

    def setDefaults(self, flat: Iterable[str]) -> None:
        """Add a flat list: key, value, key, value, ..., up to an empty key."""
        items = iter(flat)
        for key in items:
            if not key:
                return
            self.setProperty(key.strip(" \t"), next(items).strip(" \t"))

    def getName(self) -> str:
        return self.name

    def getValue(self) -> str:
        return self.value

    def getLeaf(self) -> list[Properties]:
        return list(self.leaf.values())

    def findNode(self, key: str) -> Properties | None:
        node = self
        for name in key.split("."):
            below = node.leaf.get(name)
            if below is None:
                return None
            node = below
        return node

    def getNode(self, key: str) -> Properties:
        """Return the node of a key, which is created if necessary."""
        node = self
        for name in key.split("."):
            node = node.leaf.setdefault(name, Properties(key=name))
        return node

    def hasKey(self, key: str) -> bool:
        return self.findNode(key) is not None

    def removeNode(self, name: str) -> Properties | None:
        return self.leaf.pop(name, None)

    def getProperty(self, key: str, default: str = "") -> str:
        node = self.findNode(key)
        return node.value if node is not None and node.value else default

    def setProperty(self, key: str, value: str) -> None:
        self.getNode(key).value = str(value)

    def mergeProperties(self, other: Properties) -> Properties:
        """Adopt every text of another tree."""
        for name, node in other.leaf.items():
            mine = self.leaf.setdefault(name, Properties(key=name))
            if node.value or not node.leaf:
                mine.value = node.value
            mine.mergeProperties(node)
        return self

    def propertyNames(self) -> list[str]:
        """Return the keys of all nodes that have none below them."""
        return list(self._keys(""))

    def _keys(self, prefix: str) -> Iterator[str]:
        for name, node in self.leaf.items():
            if node.leaf:
                yield from node._keys(f"{prefix}{name}.")
            else:
                yield prefix + name

    def load(self, lines: Iterable[str]) -> None:
        """Read `key: value` lines: `#` begins a comment, a backslash at the end joins lines."""
        joined = ""
        for line in lines:
            text = joined + (line.lstrip() if joined else line).rstrip("\r\n")
            joined = ""
            if text.lstrip().startswith(("#", "!")) or not text.strip():
                continue
            if text.endswith("\\"):
                joined = text[:-1]
                continue
            key, colon, value = text.partition(":")
            if not colon:
                key, _, value = text.partition("=")
            self.setProperty(unescape(key).strip(), unescape(value).strip())


_ESCAPED = {"t": "\t", "n": "\n", "f": "\f", "r": "\r"}


def unescape(text: str) -> str:
    """Remove backslashes; some letters after one stand for control characters."""
    return re.sub(r"\\(.)", lambda found: _ESCAPED.get(found[1], found[1]), text)
