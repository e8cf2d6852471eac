"""The definition files of a run: each is read once, and all searched paths are recorded."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from hashlib import sha256
from pathlib import Path
from typing import Generic, Protocol, TypeVar

import msgspec

from rtgen.compiler.frontends import Dependency
from rtgen.facts import files
from rtgen.facts.encodings import Encoded
from rtgen.facts.files import absolute_path as absolute_path

MAX_BYTES = files.MAX_BYTES
"""Maximum size of a file."""


class VirtualFile(msgspec.Struct, frozen=True):
    """A file that is not on the disk, but can be included.

    `key` is the one for generated text; a `text` that is a function is called when the file is
    included. `given`: the file is read like one given on the command line.
    """

    key: str
    text: str | Callable[[], str]
    given: bool = False


class File(Protocol):
    """Interface of the files that a library contains."""

    @property
    def name(self) -> str:
        """The displayed path."""


F = TypeVar("F", bound=File)


class Library(Generic[F]):
    """The files of a run: each is read once, and all searched paths are recorded."""

    def __init__(
        self,
        make: Callable[[str, str, Path, bytes | None], F],
        root: Path,
        include: Sequence[Path],
        main: Mapping[str, str] | None = None,
        virtual: Mapping[str, VirtualFile | Path] | None = None,
    ) -> None:
        """Initialize the library.

        `make` makes a file from its displayed name, key, path and bytes (None for one that is too
        large). `main` maps absolute paths of the files given to their displayed names. `virtual`
        are files by the name in `#include`, used if the search for it fails; a path is that of a
        file on the disk.
        """
        self._make = make
        self._root = root.resolve()
        self.include = tuple(include)
        self._main = dict(main or {})
        self._working = Path.cwd()
        self._read: dict[str, F | None] = {}
        self._dependencies: dict[str, Dependency] = {}
        self._virtual = dict(virtual or {})
        self._files: dict[str, F] = {}
        # One path of each file, by the path without links: for those given, the first of `main`,
        # which is in reverse order.
        self._paths = {files.real_path(each): each for each in self._main}
        self.trail: dict[str, None] = {}
        """The absolute paths that `open` has searched since this was cleared."""

    @property
    def dependencies(self) -> tuple[Dependency, ...]:
        """All searched paths, in order."""
        return tuple(self._dependencies.values())

    def dependency(self, absolute: str) -> Dependency:
        """Return what was found at an absolute path that was searched."""
        cached = self._dependencies.get(absolute)
        return Dependency(Path(absolute), None) if cached is None else cached

    @property
    def found(self) -> list[F]:
        """The files found at the paths of `trail`."""
        read = (self._read.get(absolute) for absolute in self.trail)
        return [source for source in read if source is not None]

    @property
    def sources(self) -> list[F]:
        """All files read, in order."""
        read = [source for source in self._read.values() if source is not None]
        return [*read, *self._files.values()]

    def virtual_texts(self) -> Iterator[tuple[str, str]]:
        """Yield the names and the texts of the virtual files, which are not read by that."""
        for name, file in self._virtual.items():
            if isinstance(file, VirtualFile):
                yield name, file.text if isinstance(file.text, str) else file.text()

    def virtual(self, name: str) -> F | None:
        """Return the virtual file of that name."""
        file = self._virtual.get(name)
        if file is None or isinstance(file, Path):
            return None if file is None else self.open(file)
        if name not in self._files:
            text = file.text if isinstance(file.text, str) else file.text()
            source = self._make(
                name, file.key, self._root / name, Encoded(text.encode())
            )
            self._files[name] = source
        return self._files[name]

    def open(
        self, path: Path | str, folder: Path | None = None, *, apart: bool = False
    ) -> F | None:
        """Return the file of a path; None if there is none.

        A file that a link leads to is that of the first path, unless it is kept `apart`. `folder`
        is the include folder in which it was found. Raises OSError for a file that cannot be read.
        """
        absolute = absolute_path(path)
        self.trail[absolute] = None
        if absolute in self._read:
            return self._read[absolute]
        source = None
        digest = None
        file = Path(absolute)
        is_file = files.is_file(file)
        if is_file and not apart:
            first = self._paths.setdefault(files.real_path(absolute), absolute)
            if first != absolute:
                source = self.open(first, folder)
                digest = self.dependency(first).sha256
        if is_file and source is None:
            data = files.read_start(file, MAX_BYTES + 1)
            digest = sha256(data).hexdigest()
            source = self._make(
                self._displayed(absolute),
                self._key(file, folder),
                Path(path),
                data if len(data) <= MAX_BYTES else None,
            )
        self._read[absolute] = source
        self._dependencies[absolute] = Dependency(file, digest)
        return source

    def note(self, dependencies: Iterable[Dependency]) -> None:
        """Record paths that were searched for a virtual file."""
        for each in dependencies:
            self._dependencies.setdefault(str(each.path), each)

    @property
    def virtual_names(self) -> tuple[str, ...]:
        """The names of virtual files."""
        return tuple(self._virtual)

    def displayed(self, folder: Path) -> str:
        """Return a folder as displayed: relative to the working folder."""
        return self._displayed(absolute_path(folder))

    def _displayed(self, absolute: str) -> str:
        if absolute in self._main:
            return self._main[absolute]
        try:
            return Path(os.path.relpath(absolute, self._working)).as_posix()
        except ValueError:  # on another drive
            return Path(absolute).as_posix()

    def _key(self, path: Path, folder: Path | None) -> str:
        real = path.resolve()
        for base in (self._root, folder.resolve() if folder else None):
            if base is not None and real.is_relative_to(base):
                return real.relative_to(base).as_posix()
        return path.name
