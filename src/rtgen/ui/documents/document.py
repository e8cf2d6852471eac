"""The file of a system as it was opened, to which a user's edits are applied."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from rtgen.compiler.backends.profiles.rts_profile import system_text
from rtgen.compiler.diagnostics import InputError
from rtgen.compiler.frontends.kit import located_xml
from rtgen.compiler.frontends.profiles import profile_yaml, rts_profile
from rtgen.compiler.frontends.profiles.profile_yaml import YAML_SUFFIXES
from rtgen.compiler.kit.xml_text import NOT_IN_XML
from rtgen.compiler.model import System
from rtgen.facts import encodings
from rtgen.facts.decoded_text import NotEncodableError
from rtgen.ui.documents import xml_edits, yaml_edits
from rtgen.ui.documents.elements import Editable
from rtgen.ui.documents.profile import Change, Profile

_MAX_NAME: Final = 200


class DocumentError(Exception):
    """The file cannot be changed, or not be written; the message says why."""


class Document:
    """The octets of a system's file, and what they become by changes."""

    def __init__(self, file: str, data: bytes) -> None:
        """Raise InputError if the file cannot be parsed; `file` is its name in diagnostics."""
        self.file = file
        self.data = data
        self._is_yaml = _is_yaml(file)

    @classmethod
    def new(cls, name: str) -> Document:
        """Return the document of a system without components."""
        empty = System(
            name=name[:_MAX_NAME],
            id="",
            file="",
            abstract="",
            components=(),
            connections=(),
        )
        return cls("system.xml", system_text(empty).encode())

    def octets(self, changes: Sequence[Change], file: str = "") -> bytes:
        """Return the content after changes, in the form of another file's name if one is given.

        Only what the changes concern differs from the file. Raises DocumentError.
        """
        written = self._written(changes)
        if not file or _is_yaml(file) is self._is_yaml:
            return written
        if self._is_yaml:
            text = encodings.decode(written, standard=True).normal
            return profile_yaml.to_xml(text, file).encode()
        text = located_xml.decode(written, file)
        return profile_yaml.to_yaml(located_xml.parse(text, file)).encode()

    def system(self, changes: Sequence[Change]) -> System:
        """Return the system after changes. Raises DocumentError."""
        result = rts_profile.load_bytes(self.octets(changes), self.file)
        if result.system is None:
            raise DocumentError(str(InputError(result.diagnostics)))
        return result.system

    def _written(self, changes: Sequence[Change]) -> bytes:
        if not changes:
            return self.data
        return self._yaml(changes) if self._is_yaml else self._xml(changes)

    def _xml(self, changes: Sequence[Change]) -> bytes:
        text = located_xml.decode(self.data, self.file)
        root = xml_edits.parse(text, self.file)
        _change(root, changes)
        return self._encoded(xml_edits.written(text, root))

    def _yaml(self, changes: Sequence[Change]) -> bytes:
        read = encodings.decode(self.data, standard=True)
        text = read.text
        root = _editable(profile_yaml.parse(text, self.file))
        before = profile_yaml.yaml_content(root)
        _change(root, changes)
        after = profile_yaml.yaml_content(root)
        try:
            written = yaml_edits.written(text, before, after)
        except yaml_edits.UnlikeError:
            raise DocumentError(
                f"{self.file} is written in a way that cannot be changed in its place"
            ) from None
        try:
            return read.encode(written)
        except NotEncodableError as error:
            raise DocumentError(f"{self.file}: {error}") from error

    def _encoded(self, text: str) -> bytes:
        try:
            return located_xml.encode(text, self.data)
        except NotEncodableError as error:
            raise DocumentError(f"{self.file}: {error}") from error


def _change(root: Editable, changes: Sequence[Change]) -> None:
    profile = Profile(root)
    for change in changes:
        try:
            change(profile)
        except LookupError as error:
            raise DocumentError(str(error)) from error
    _require_characters(root)


def _require_characters(element: Editable) -> None:
    """Raise DocumentError for a new text that XML cannot represent."""
    for (_, name), text in element.attributes.items():
        if NOT_IN_XML.search(text):
            message = f"{name}: {text[:80]!r} has a character that a file cannot hold"
            raise DocumentError(message)
    for child in element.children:
        _require_characters(child)


def _editable(element: located_xml.Element) -> Editable:
    children = [*map(_editable, element.children)]
    return Editable(element.name, dict(element.attributes), children, element.text)


def _is_yaml(file: str) -> bool:
    return file.lower().endswith(YAML_SUFFIXES)
