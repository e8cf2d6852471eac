"""Names of the variables in a generated function, and its lines."""

from __future__ import annotations

from collections.abc import Container

from rtgen.layouts.cdr import Path
from rtgen.typemap.python_names import identifier

_LONGEST = 32
_FIXED = frozenset(
    {"cls", "data", "failure", "item", "little_endian", "made", "offset", "out"}
    | {"self", "size", "unpack"}
)


class Locals:
    """Hands out variable names: the path of what they hold, with `_` between its parts."""

    def __init__(self, reserved: Container[str], *own: str) -> None:
        self._reserved = reserved
        self._taken = {*_FIXED, *own}
        self._names: dict[tuple[str, Path], str] = {}

    def name(self, path: Path, prefix: str = "") -> str:
        """The variable for a value; with a prefix, for something about it (`n_` its count)."""
        key = (prefix, path)
        if key not in self._names:
            joined = "_".join(part for part in path if part.isidentifier()) or "value"
            name = identifier((prefix + joined)[:_LONGEST])
            while name in self._taken or name in self._reserved:
                name += "_"
            self._taken.add(name)
            self._names[key] = name
        return self._names[key]


class Body:
    """Lines of a function: statements that come first, and the others with their indent."""

    def __init__(self) -> None:
        self.first: list[str] = []
        self._lines: list[str] = []
        self._indent = 0

    def add(self, statement: str) -> None:
        """A statement at the present indent."""
        self._lines.append("    " * self._indent + statement)

    def block(self, head: str) -> None:
        """A statement that opens a block; what follows stands inside of it."""
        self.add(head)
        self._indent += 1

    def end(self) -> None:
        """Closes the innermost block."""
        self._indent -= 1

    def choose(self, variable: str, attribute: str, layout: str) -> None:
        """`variable` becomes the layout's attribute for the byte order."""
        one, other = f"{layout}.{attribute}_little", f"{layout}.{attribute}_big"
        self.first.append(f"{variable} = {one} if little_endian else {other}")

    @property
    def lines(self) -> list[str]:
        """All lines, in order."""
        return self.first + self._lines
