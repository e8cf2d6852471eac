"""Profile files, RtcProfile and RtsProfile, as a tree with places; XML, or YAML by the suffix."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from rtgen.compiler.diagnostics import Diagnostic, InputError
from rtgen.compiler.frontends.kit import characters, located_xml
from rtgen.compiler.frontends.kit.findings import Findings
from rtgen.compiler.frontends.kit.located_xml import Element
from rtgen.compiler.frontends.kit.suggestions import nearest
from rtgen.compiler.frontends.profiles import profile_yaml
from rtgen.compiler.frontends.profiles.profile_yaml import YAML_SUFFIXES
from rtgen.compiler.frontends.profiles.rules import TOO_MANY, UNREADABLE
from rtgen.facts import files
from rtgen.facts.decoded_text import with_line_feeds
from rtgen.facts.encodings import decode
from rtgen.facts.files import UnreadableError

_MAX_BYTES = 16 * 1024 * 1024


class ProfileTree(NamedTuple):
    """A profile's text and tree; the tree is None, after a diagnostic, if it is malformed."""

    root: Element | None
    text: str


def sink() -> Findings:
    """Return an empty collection of diagnostics about one profile."""
    return Findings(TOO_MANY)


def read(path: Path, file: str, report: Callable[[Diagnostic], None]) -> bytes | None:
    """Read a profile displayed as `file`; None, after a diagnostic, if it cannot be read."""
    try:
        return files.read_file(path, _MAX_BYTES)
    except UnreadableError as error:
        near = None if files.exists(path) else _near(path)
        hint = f"did you mean {Path(file).with_name(near)}?" if near else None
        report(UNREADABLE.at(None, f"cannot open {file}: {error}", hint=hint))
        return None


def _near(path: Path) -> str | None:
    """Return the name of the profile that a missing file is likely meant as."""
    try:
        names = [each.name for each in files.in_order(path.parent)]
    except OSError:
        return None
    of_profiles = [n for n in names if n.lower().endswith((".xml", *YAML_SUFFIXES))]
    if path.name == "system.xml" and len(of_profiles) == 1:
        return of_profiles[0]
    return nearest(path.name, sorted(of_profiles))


def text_of(
    data: bytes,
    file: str,
    report: Callable[[Diagnostic], None],
    encoding: str = "auto",
) -> str:
    """Return the text of a profile, with a line feed as its line end. Raises InputError."""
    if not file.lower().endswith(YAML_SUFFIXES):
        return with_line_feeds(located_xml.decode(data, file))
    read = characters.read(data, file, encoding, standard=characters.YAML)
    for problem in read.problems:
        report(problem)
    return read.text


def parse(
    data: bytes,
    file: str,
    report: Callable[[Diagnostic], None],
    encoding: str = "auto",
) -> ProfileTree:
    """Parse a profile.

    `file` is the path in diagnostics, `encoding` that of YAML that is not UTF-8.
    """
    text = None
    try:
        text = text_of(data, file, report, encoding)
        if file.lower().endswith(YAML_SUFFIXES):
            return ProfileTree(profile_yaml.parse(text, file), text)
        return ProfileTree(located_xml.parse(text, file), text)
    except InputError as error:
        for diagnostic in error.diagnostics:
            report(diagnostic)
        return ProfileTree(None, decode(data).normal if text is None else text)
