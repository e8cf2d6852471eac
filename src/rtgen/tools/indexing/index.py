"""Index of definitions and uses of names, by file and by key.

A key identifies a definition across files and languages: the language, then the name from the
outermost scope (`idl RTC::Time::sec`), preceded by the defining file if names are local to files
(`cdl /p/board.cdl#sMotor::set`). `file /p/a.idl` is a file itself.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from pathlib import Path

from rtgen.compiler.diagnostics import Span
from rtgen.compiler.kit.resources import IDL_FILES, idl_file
from rtgen.facts.files import absolute_path, is_file
from rtgen.tools.indexing.text import Text


class Kind(StrEnum):
    """Kind of a definition; the value is its name in hovers."""

    FILE = "file"
    MODULE = "module"
    STRUCT = "struct"
    UNION = "union"
    EXCEPTION = "exception"
    ENUM = "enum"
    ENUMERATOR = "enumerator"
    BITS = "bitmask"
    TYPEDEF = "typedef"
    CONSTANT = "constant"
    INTERFACE = "interface"
    OPERATION = "operation"
    PARAMETER = "parameter"
    ATTRIBUTE = "attribute"
    MEMBER = "member"
    COMPONENT = "component"
    PORT = "port"
    SIGNATURE = "signature"
    FUNCTION = "function"
    CELLTYPE = "celltype"
    CELL = "cell"
    DEVICE = "device"
    OBJECT = "object"
    NODE = "node"
    INSTANCE = "instance"


@dataclass(frozen=True, slots=True)
class Definition:
    """A definition: its name is at [start, end), the whole definition at [first, last)."""

    key: str
    name: str
    kind: Kind
    start: int
    end: int
    first: int
    last: int
    container: str = ""
    detail: str = ""


@dataclass(frozen=True, slots=True, order=True)
class Occurrence:
    """A name at [start, end); `defines`: it is the definition."""

    start: int
    end: int
    key: str
    defines: bool = False


@dataclass(frozen=True, eq=False)
class FileIndex:
    """The names of a file, in order of their places in `text`."""

    path: str
    text: Text
    definitions: tuple[Definition, ...]
    occurrences: tuple[Occurrence, ...]
    _starts: list[int] = field(default_factory=list, repr=False)

    def __post_init__(self) -> None:
        self._starts.extend(each.start for each in self.occurrences)

    def at(self, offset: int) -> Occurrence | None:
        """Return the innermost name that contains an offset or ends there."""
        occurrence = None
        index = bisect_right(self._starts, offset)
        for each in reversed(self.occurrences[max(index - 8, 0) : index]):
            if each.end >= offset and (
                occurrence is None
                or each.end - each.start < occurrence.end - occurrence.start
            ):
                occurrence = each
        return occurrence

    def between(self, start: int, end: int) -> Iterator[Occurrence]:
        """Yield the names that start in [start, end)."""
        index = bisect_right(self._starts, start - 1)
        for each in self.occurrences[index:]:
            if each.start >= end:
                return
            yield each

    def around(self, offset: int) -> list[Definition]:
        """Return the definitions that contain an offset, outermost first."""
        return [d for d in self.definitions if d.first <= offset < d.last]


@dataclass(frozen=True, slots=True)
class Place:
    """A name in a file."""

    file: FileIndex
    start: int
    end: int
    defines: bool


class Index:
    """The names of a project's files; immutable."""

    def __init__(self, files: Iterable[FileIndex]) -> None:
        self.files: dict[str, FileIndex] = {file.path: file for file in files}
        self._definitions: dict[str, list[tuple[FileIndex, Definition]]] = {}
        self._places: dict[str, list[Place]] = {}
        self._children: dict[str, list[tuple[FileIndex, Definition]]] = {}
        for file in self.files.values():
            for d in file.definitions:
                self._definitions.setdefault(d.key, []).append((file, d))
                self._children.setdefault(d.container, []).append((file, d))
            for o in file.occurrences:
                place = Place(file, o.start, o.end, o.defines)
                self._places.setdefault(o.key, []).append(place)

    def definitions(self, key: str) -> list[tuple[FileIndex, Definition]]:
        """Return the definitions of a key."""
        return self._definitions.get(key, [])

    def definition(self, key: str) -> Definition | None:
        """Return the first definition of a key."""
        definitions = self._definitions.get(key)
        return definitions[0][1] if definitions else None

    def places(self, key: str) -> list[Place]:
        """Return all places of a key's name."""
        return self._places.get(key, [])

    def inside(self, key: str) -> list[Definition]:
        """Return the definitions directly inside; the empty key stands for the outermost scope."""
        return [definition for _, definition in self._children.get(key, [])]

    def all(self) -> Iterator[tuple[FileIndex, Definition]]:
        """Yield all definitions."""
        for definitions in self._definitions.values():
            yield from definitions


@dataclass(slots=True)
class _Names:
    """Names of a file during collection."""

    definitions: dict[tuple[Span, str], tuple[str, Kind, Span, str, str]] = field(
        default_factory=dict
    )
    uses: dict[tuple[Span, str], bool] = field(default_factory=dict)


class Collector:
    """Collects names by rtgen's spans, and makes the index of each file."""

    def __init__(self) -> None:
        self._files: dict[str, _Names] = {}

    def define(
        self,
        key: str,
        name: str,
        kind: Kind,
        span: Span,
        extent: Span | None = None,
        *,
        container: str = "",
        detail: str = "",
    ) -> None:
        """Add a definition; `extent` is its whole span, by default that of its name."""
        names = self._files.setdefault(span.file, _Names())
        if extent is None or extent.file != span.file:
            extent = span
        names.definitions.setdefault(
            (span, key), (name, kind, extent, container, detail)
        )
        names.uses[span, key] = True

    def refer(self, key: str, span: Span) -> None:
        """Add a use of a name."""
        names = self._files.setdefault(span.file, _Names())
        names.uses.setdefault((span, key), False)

    @property
    def files(self) -> list[str]:
        """The displayed paths of files with names."""
        return list(self._files)

    def indexes(self, texts: Mapping[str, Text]) -> Iterator[FileIndex]:
        """Yield the indexes of the files with a text, whose names are then no longer collected.

        `texts` are by displayed path.
        """
        for file in self.files:
            names = self._files.pop(file)
            path = path_of(file)
            text = texts.get(file)
            if text is not None and is_file(
                Path(path)
            ):  # others exist only for includes
                yield _file_index(path, text, names)


def _file_index(path: str, text: Text, names: _Names) -> FileIndex:
    definitions = []
    for (span, key), (name, kind, extent, container, detail) in sorted(
        names.definitions.items()
    ):
        start, end = text.offsets(span)
        first, last = text.offsets(extent)
        definitions.append(
            Definition(
                *(key, name, kind, start, end, min(first, start), max(last, end)),
                *(container, detail),
            )
        )
    occurrences = sorted(
        Occurrence(*text.offsets(span), key, defines)
        for (span, key), defines in names.uses.items()
    )
    return FileIndex(path, text, tuple(definitions), tuple(occurrences))


def path_of(file: str) -> str:
    """Return the absolute path of a displayed path."""
    path = absolute_path(file)
    if file in IDL_FILES and not Path(path).is_file():
        return str(idl_file(file))
    return path
