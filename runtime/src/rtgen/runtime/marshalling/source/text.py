"""Names and lines of compiled functions."""

from __future__ import annotations

import linecache
import re
from keyword import iskeyword
from typing import Any

from rtgen.runtime.marshalling.layouts.nodes import (
    Path,
)

_MAX_NAME = 32
_NO_IDENTIFIER = re.compile("[^A-Za-z0-9_]")
_FIXED = frozenset(
    {"cls", "data", "discriminator", "failure", "inner", "item", "little_endian"}
    | {"offset", "out", "same", "selected", "self", "size", "unpack", "value"}
    | {
        "end",
        "get",
        "list_end",
        "member",
        "pack_header",
        "put",
        "put_header",
        "required",
        "start",
        "values",
        "whole",
        "ValueError",
        "bytearray",
        "bytes",
        "len",
        "list",
        "memoryview",
        "packed",
        "range",
    }
)


def entered(text: str, file: str) -> str:
    """Enter source text in `linecache` as a file `<name>`; return its name.

    Another text of that name gets a number; the same text, of a type compiled again, has one entry.
    """
    entry = (len(text), None, text.splitlines(keepends=True), file)
    number = 1
    name = file
    while linecache.cache.setdefault(name, entry)[:3] != entry[:3]:
        number += 1
        name = f"{file[:-1]} {number}>"
    return name


class Namespace:
    """The globals of a compiled function, which its local variables must not shadow."""

    def __init__(self) -> None:
        self.values: dict[str, object] = {}
        self._names: dict[int, str] = {}
        self._taken: set[str] = {*_FIXED}

    def bind(self, name: str, value: object) -> str:
        """Bind an object; return its name, `name` if that is free."""
        bound = self._names.get(id(value))
        if bound is None:
            bound = self._names[id(value)] = self.free(name)
            self.values[bound] = value
        return bound

    def free(self, text: str) -> str:
        """Return an unused identifier, similar to a name of any characters.

        It has ASCII characters alone, since Python changes others (PEP 3131).
        """
        name = _NO_IDENTIFIER.sub("_", text)
        if not name.strip("_") or name[0].isdigit():
            name = f"of_{name}"
        while name in self._taken or iskeyword(name):
            name += "_"
        self._taken.add(name)
        return name


class Locals:
    """Allocates variable names: the path of the value, with `_` between its parts."""

    def __init__(self, namespace: Namespace) -> None:
        self._namespace = namespace
        self._names: dict[tuple[str, Path], str] = {}

    def name(self, path: Path, prefix: str = "") -> str:
        """Return the variable for a value; with a prefix, for a property (`n_`: its count)."""
        key = (prefix, path)
        if key not in self._names:
            joined = "_".join(part for part in path if part.isidentifier()) or "value"
            self._names[key] = self._namespace.free((prefix + joined)[:_MAX_NAME])
        return self._names[key]


class Body:
    """Lines of a function. Layouts are selected by byte order where `choose_here` was called."""

    def __init__(self, namespace: Namespace) -> None:
        self._namespace = namespace
        self.lines: list[str] = []
        self._indent = 0
        self._choices = (0, 0)
        self._chosen: set[str] = set()

    def add(self, statement: str) -> None:
        """Append a statement at the current indentation."""
        self.lines.append("    " * self._indent + statement)

    def block(self, head: str) -> None:
        """Append a statement that opens a block for the statements that follow."""
        self.add(head)
        self._indent += 1

    def end(self) -> None:
        """Close the innermost block."""
        self._indent -= 1

    def choose_here(self) -> None:
        """Select layouts by byte order here, not at the start of the function."""
        self._choices = (len(self.lines), self._indent)
        self._chosen.clear()

    def choose(self, variable: str, name: str, layout: Any, attribute: str) -> None:
        """Assign the layout's attribute for the byte order to `variable`."""
        if variable in self._chosen:
            return
        self._chosen.add(variable)
        one = self._namespace.bind(
            f"{name}_little", getattr(layout, f"{attribute}_little")
        )
        other = self._namespace.bind(f"{name}_big", getattr(layout, f"{attribute}_big"))
        place, indent = self._choices
        text = f"{variable} = {one} if little_endian else {other}"
        self.lines.insert(place, "    " * indent + text)
        self._choices = (place + 1, indent)
