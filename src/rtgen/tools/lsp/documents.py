"""Documents open in the editor, with their possibly unsaved texts and their languages."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from enum import StrEnum
from pathlib import Path
from weakref import ref

from lsprotocol.types import (
    PositionEncodingKind,
    TextDocumentContentChangeEvent,
    TextDocumentContentChangePartial,
)
from pygls.uris import from_fs_path, to_fs_path

from rtgen.compiler.project import FILE_NAME
from rtgen.facts.cdl_files import CDL_SUFFIXES
from rtgen.facts.decoded_text import encoded
from rtgen.facts.device_files import TEXT_SUFFIXES, XML_SUFFIXES
from rtgen.facts.encodings import Encoded, decode
from rtgen.facts.file_names import MAX_PATH, problem
from rtgen.facts.files import UnreadableError, absolute_path, read_file
from rtgen.facts.idl_files import IDL_SUFFIXES
from rtgen.tools.indexing.text import Shift, Shifts, Text

MAX_CHARACTERS = 8 * 1024 * 1024
"""Maximum length of a document; of a larger one, the text on the disk is used."""

MAX_OPEN = 8 * MAX_CHARACTERS
"""Maximum length of all open documents together; further ones are read from the disk."""


_MAX_URI = len("file://") + 3 * MAX_PATH
"""Each octet of a path takes three characters at most."""


class Language(StrEnum):
    """Languages of the server, by the ids that editors use."""

    IDL = "idl"
    CDL = "cdl"
    EDS = "eds"
    XDD = "xdd"
    BUS = "toml"
    PROJECT = "rtgen.toml"
    PROFILE = "xml"


_SUFFIXES = {
    **dict.fromkeys(IDL_SUFFIXES, Language.IDL),
    **dict.fromkeys(CDL_SUFFIXES, Language.CDL),
    **dict.fromkeys(TEXT_SUFFIXES, Language.EDS),
    **dict.fromkeys(XML_SUFFIXES, Language.XDD),
    ".toml": Language.BUS,
    ".xml": Language.PROFILE,
    ".yaml": Language.PROFILE,
    ".yml": Language.PROFILE,
}


def language_of(path: str) -> Language | None:
    """Return the language of a file by its name."""
    if Path(path).name == FILE_NAME:
        return Language.PROJECT
    return _SUFFIXES.get(Path(path).suffix.lower())


def path_of(uri: str) -> str | None:
    """Return the absolute path of a document; None if it is not a file."""
    if not uri.startswith("file:") or len(uri) > _MAX_URI:
        return None
    try:
        path = to_fs_path(uri)
    except ValueError:  # of urllib, for an invalid host
        return None
    if path is None or problem(path) is not None:
        return None
    return absolute_path(path)


def uri_of(path: str) -> str:
    """Return the URI of a file."""
    uri: str | None = from_fs_path(path)
    assert uri is not None, "an absolute path has an address"
    return uri


def _encoding(path: str, text: Text) -> str:
    """Return the encoding of a file, if an editor reads the same text from it; else UTF-8."""
    if text.source.isascii():
        return "utf8"
    try:
        read = decode(read_file(Path(path)))
    except UnreadableError:
        return "utf8"
    return read.encoding if read.normal == text.normal else "utf8"


MAX_EDITS = 64
"""Maximum number of edits that are kept separately; earlier ones are merged."""


@dataclass(frozen=True, slots=True)
class Document:
    """An open document at a version; `edits` are the last ones, each with the text before it, if
    an analysis still has that.

    `encoding`, a key of `decoded_text.TITLES`, is that of its file.
    """

    uri: str
    path: str
    language: Language
    version: int
    text: Text
    edits: tuple[tuple[ref[Text], Shift], ...] = ()
    encoding: str = "utf8"

    def shift_from(self, text: Text) -> Shift | Shifts:
        """Return the edits since the document had the text, or their sum."""
        if text is self.text:
            return Shifts(())
        for number, (before, _) in enumerate(self.edits):
            if before() is text:
                return Shifts([shift for _, shift in self.edits[number:]])
        return Shift.between(text.source, self.text.source)

    @property
    def data(self) -> bytes:
        """The text in the encoding of its file, if the file has that text's characters."""
        source = self.text.source.removeprefix("\ufeff")
        if self.encoding != "utf8":
            with suppress(UnicodeEncodeError):
                return Encoded(encoded(source, self.encoding), self.encoding)
        return Encoded(source.encode("utf-8", "replace"))


@dataclass(frozen=True, slots=True)
class Snapshot:
    """Open documents by absolute path, as contents for `files.overlaid`, and their texts."""

    contents: Mapping[str, bytes]
    texts: Mapping[str, Text]


class Documents:
    """The open documents by path."""

    def __init__(self) -> None:
        self.encoding = PositionEncodingKind.Utf16
        self._open: dict[str, Document] = {}

    def open(self, uri: str, version: int, source: str) -> Document | None:
        """Add a document; None for an unknown language, or a text that is too large."""
        path = path_of(uri)
        language = None if path is None else language_of(path)
        if path is None or language is None or not self._has_room(path, source):
            return None
        text = Text(source)
        encoding = _encoding(path, text)
        document = Document(uri, path, language, version, text, encoding=encoding)
        self._open[path] = document
        return document

    def change(
        self,
        uri: str,
        version: int,
        changes: Sequence[TextDocumentContentChangeEvent],
    ) -> Document | None:
        """Apply edits in order; None if the document is not open."""
        document = self.of(uri)
        if document is None:
            return None
        text = document.text
        edits = [*document.edits]
        for change in changes:
            before = text
            if isinstance(change, TextDocumentContentChangePartial):
                text, shift = text.replaced(change.range, change.text, self.encoding)
            else:
                text = Text(change.text)
                shift = Shift.between(before.source, text.source)
            edits.append((ref(before), shift))
        if not self._has_room(document.path, text.source):
            self.close(uri)
            return None
        changed = replace(
            document, version=version, text=text, edits=tuple(edits[-MAX_EDITS:])
        )
        self._open[document.path] = changed
        return changed

    def _has_room(self, path: str, source: str) -> bool:
        others = sum(len(d.text.source) for p, d in self._open.items() if p != path)
        return len(source) <= min(MAX_CHARACTERS, MAX_OPEN - others)

    def close(self, uri: str) -> Document | None:
        """Remove a document, and return it."""
        path = path_of(uri)
        return None if path is None else self._open.pop(path, None)

    def of(self, uri: str) -> Document | None:
        """Return the open document of a URI."""
        path = path_of(uri)
        return None if path is None else self._open.get(path)

    def at(self, path: str) -> Document | None:
        """Return the open document of a file."""
        return self._open.get(path)

    @property
    def all(self) -> tuple[Document, ...]:
        """The open documents."""
        return tuple(self._open.values())

    def snapshot(self) -> Snapshot:
        """Return a snapshot of the open documents."""
        documents = self.all
        return Snapshot(
            {document.path: document.data for document in documents},
            {document.path: document.text for document in documents},
        )
