"""Cache of results of reading between runs, each with the files that it depends on."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Sequence
from hashlib import sha256
from pathlib import Path
from typing import Any, Final, Protocol, TypeVar

from rtgen.compiler.frontends import Dependency
from rtgen.compiler.frontends.kit.library import MAX_BYTES
from rtgen.facts import files

_RUNS: Final = 8
"""A result that was not used for this number of runs is dropped."""


class Reading(Protocol):
    """A result with all paths that were read or searched for."""

    @property
    def dependencies(self) -> Sequence[Dependency]:
        """The paths with the hashes of their contents."""


R = TypeVar("R", bound=Reading)


class Memo:
    """Results by key, valid while the files that they depend on are unchanged.

    The key contains everything else that a result depends on. Files are hashed once per run.
    """

    def __init__(self) -> None:
        self._entries: dict[Hashable, tuple[int, Any]] = {}
        self._hashes: dict[Path, str | None] = {}
        self._run = 0

    def begin(self) -> None:
        """Start a run: files may have changed."""
        self._run += 1
        self._hashes.clear()
        last = self._run - _RUNS
        self._entries = {
            k: each for k, each in self._entries.items() if each[0] >= last
        }

    def find(self, key: Hashable) -> Any:
        """Return the valid result of a key; None without one."""
        if key not in self._entries:
            return None
        _, result = self._entries[key]
        if not self._is_valid(result.dependencies):
            return None
        self._entries[key] = self._run, result
        return result

    def keep(self, key: Hashable, result: Reading) -> None:
        """Store a result of this run."""
        self._entries[key] = self._run, result

    def read(
        self, key: Hashable, make: Callable[[], R], fits: Callable[[R], bool]
    ) -> R:
        """Return the valid result of a key; else the result of `make`, stored if it `fits`."""
        result: R | None = self.find(key)
        if result is None:
            result = make()
            if fits(result):
                self.keep(key, result)
        return result

    def _is_valid(self, dependencies: Iterable[Dependency]) -> bool:
        return all(self._hash(each.path) == each.sha256 for each in dependencies)

    def _hash(self, path: Path) -> str | None:
        if path not in self._hashes:
            try:
                there = files.is_file(path)
                data = files.read_start(path, MAX_BYTES + 1) if there else None
            except OSError:
                data = None
            self._hashes[path] = None if data is None else sha256(data).hexdigest()
        return self._hashes[path]
