"""Kinds of definitions whose size is a parameter, and the texts that such definitions repeat."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

Files = dict[str, str]
Maker = Callable[[int], Files]
Commands = Sequence[tuple[str, ...]]


@dataclass(frozen=True, slots=True)
class Kind:
    """A kind of definition: generator of its files, its sizes, the commands that read it."""

    make: Maker
    sizes: tuple[int, ...]
    commands: Commands


class Kinds(dict[str, Kind]):
    """Kinds by name, for a language."""

    def __init__(self, commands: Commands) -> None:
        self._commands = commands

    def add(
        self, *sizes: int, commands: Commands | None = None
    ) -> Callable[[Maker], Maker]:
        """Register a generator under its name; commands default to those of the language."""

        def register(make: Maker) -> Maker:
            name = make.__name__.replace("_", " ")
            self[name] = Kind(make, sizes, commands or self._commands)
            return make

        return register


def lines(size: int, line: Callable[[int], str], first: int = 0) -> str:
    return "\n".join(line(i) for i in range(first, first + size))


def chain(size: int, first: str, line: str) -> str:
    """Return a line, and further ones with their numbers and those of the lines before."""
    return f"{first}\n{lines(size, lambda i: line.format(i, i - 1), 1)}"
