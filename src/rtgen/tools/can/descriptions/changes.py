"""What a written description says in another way than the one it was made from, and why."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Final

import msgspec

from rtgen.compiler.backends.canopen.portable_eds import MARK
from rtgen.compiler.backends.canopen.rules import CHANGED
from rtgen.compiler.diagnostics import Diagnostic, Span
from rtgen.compiler.frontends.eds import ini, xdd
from rtgen.compiler.frontends.eds.findings import Findings
from rtgen.compiler.frontends.eds.ini import Document, Entry, Section
from rtgen.compiler.frontends.eds.numbers import parse
from rtgen.compiler.frontends.eds.outline import (
    COMMISSIONING,
    LISTS,
    PLAIN,
    standard_name,
)
from rtgen.facts.device_files import XML_SUFFIXES, is_configured
from rtgen.facts.encodings import Encoded

_DEFAULTS: Final = {
    "pdomapping": "0",
    "objecttype": "0x7",
    "objflags": "0",
    "subnumber": "0",
    "compactsubobj": "0",
}
"""The values that a key has in CiA 306 without being written."""
_OF_A_DCF: Final = ("parametervalue", "denotation", "uploadfile", "downloadfile")
_OF_FILES: Final = ("filename", "edsversion", "supportedobjects")
"""Keys that each form has in its own way, or that are told with their list."""
_VALUES: Final = ("defaultvalue", "parametervalue", "lowlimit", "highlimit")
_TOLD: Final = ("datatype", "accesstype", "parametername", "objecttype", "subnumber")
"""Keys that are told when they are added."""
_WRITTEN_OUT: Final = re.compile(
    r"[0-9a-f]{4}(?:name|value|denotation)|m\d+.*|(?:supported|connected)modules|dynamicchannels|"
    r"tools?\d*"
)
"""Sections of compact objects and modules, whose objects are written one by one."""
_COMPACT: Final = "compactsubobj"
_SHORT: Final = 60
_NUMBER: Final = re.compile(r"0[xX][0-9a-fA-F]+|[0-9]+")
_WRAPS: Final = frozenset(1 << 8 * octets for octets in range(1, 9))
"""The differences between a negative number and its two's complement."""


class Changes(msgspec.Struct, frozen=True):
    """The changes, and the findings about the source that are the reason of none of them."""

    changes: tuple[Diagnostic, ...]
    unexplained: tuple[Diagnostic, ...]


def changes(
    source: Path,
    octets: bytes,
    findings: Sequence[Diagnostic],
    target: Path,
    text: str,
) -> Changes:
    """Compare a description with the `text` written for it; `findings` are those of the source."""
    before = _document(source, octets)
    after = _document(target, text.encode())
    comparison = _Comparison(before, after, findings, is_configured(target))
    notes = (*comparison.notes(), *_kept(before, text))
    used = comparison.used
    rest = tuple(d for n, d in enumerate(findings) if n not in used)
    return Changes(notes, rest)


def _document(path: Path, octets: bytes) -> Document:
    sink = Findings()
    if path.suffix.lower() in XML_SUFFIXES:
        return xdd.read(octets, path.as_posix(), sink)
    encoding = octets.encoding if isinstance(octets, Encoded) else "auto"
    return ini.read(octets, path.as_posix(), sink, encoding)


def _kept(before: Document, text: str) -> Iterator[Diagnostic]:
    """Yield a note of the lines that are comments, since other tools refuse them."""
    lines = [li.removeprefix(MARK) for li in text.split("\n") if li.startswith(MARK)]
    if lines:
        keys = ", ".join(dict.fromkeys(line.partition("=")[0] for line in lines))
        message = (
            f"{len(lines)} lines are comments, which rtgen reads ({keys[:_SHORT]}): "
            "strict readers refuse them"
        )
        yield CHANGED.at(before.start, message)


class _Comparison:
    def __init__(
        self,
        before: Document,
        after: Document,
        findings: Sequence[Diagnostic],
        configured: bool,
    ) -> None:
        self._before = before
        self._after = {standard_name(name): s for name, s in after.sections.items()}
        self._findings = findings
        self._configured = configured
        self._by_line: dict[int, list[int]] = {}
        for number, finding in enumerate(findings):
            if finding.span is not None:
                self._by_line.setdefault(finding.span.line, []).append(number)
        self.used: set[int] = set()

    def notes(self) -> Iterator[Diagnostic]:
        yield from self._lists()
        left_out: list[Entry] = []
        for written, section in self._before.sections.items():
            name = standard_name(written)
            if name in LISTS or _WRITTEN_OUT.fullmatch(name):
                continue
            other = self._after.get(name)
            if other is None:
                is_dcf = name == COMMISSIONING and not self._configured
                why = (
                    "it belongs to a DCF" if is_dcf else "no object is described by it"
                )
                what = f"[{section.name}] is left out"
                yield self._note(section.span, what, why)
                continue
            if section.name.lower() != name:
                what = f"[{section.name}] is written as [{other.name}]"
                yield self._note(section.span, what, "CiA 306 names it so")
            for key, entry in section.entries.items():
                if key == _COMPACT or (
                    _COMPACT in section.entries and key != "parametername"
                ):
                    continue
                if key in _OF_A_DCF and entry.value and not self._configured:
                    left_out.append(entry)
                    continue
                yield from self._entry(section.name, entry, other.entries.get(key))
            yield from self._added(section, other)
        if left_out:
            keys = ", ".join(dict.fromkeys(e.key for e in left_out))
            what = f"{len(left_out)} configured values are left out ({keys})"
            yield self._note(left_out[0].key_span, what, "they belong to a DCF")

    def _entry(
        self, section: str, entry: Entry, other: Entry | None
    ) -> Iterator[Diagnostic]:
        value = "" if other is None else other.value
        key = entry.key.lower()
        if key in _OF_FILES or _same(entry.value, value, _DEFAULTS.get(key, "")):
            return
        if other is None and key not in _VALUES and _same(entry.value, "0"):
            return  # a flag or number that is 0 without being written
        stated = f"{entry.key}={entry.value[:_SHORT]}"
        what = f"{stated} of [{section}] is left out"
        if value and other:
            now = f"{other.key}={value[:_SHORT]}"
            what = f"{stated} of [{section}] is written as {now}"
        fallback = "CiA 306 does not have it here"
        yield self._note(entry.span, what, fallback)

    def _added(self, section: Section, other: Section) -> Iterator[Diagnostic]:
        for key, entry in other.entries.items():
            before = section.entries.get(key)
            if key in _TOLD and before is None and _COMPACT not in section.entries:
                if _same(entry.value, "", _DEFAULTS.get(key, "")):
                    continue
                what = f"[{section.name}] has {entry.key}={entry.value[:_SHORT]} now"
                yield self._note(section.span, what, "CiA 306 requires it")

    def _note(self, span: Span, what: str, fallback: str) -> Diagnostic:
        """Return a note of a change, with what was found in its line as the reason."""
        reasons = self._by_line.get(span.line, ())
        for number in reasons:
            finding = self._findings[number]
            self.used.add(number)
            return CHANGED.at(span, f"{what}: {finding.message} ({finding.code})")
        return CHANGED.at(span, f"{what}: {fallback}")

    def _lists(self) -> Iterator[Diagnostic]:
        """Yield what the lists of objects name no more, or in another list."""
        listed = {
            index
            for name in LISTS
            if (section := self._before.sections.get(name)) is not None
            for index in _indices(section.numbered())
        }
        for name in LISTS:
            other = self._after.get(name)
            for index in _indices(() if other is None else other.numbered()):
                head = self._before.sections.get(f"{index:04x}")
                if index not in listed and head is not None and listed:
                    what = f"{index:04X}h is in [{PLAIN[name]}] now"
                    yield self._note(head.span, what, "it was in no list")
        for name in LISTS:
            section, other = self._before.sections.get(name), self._after.get(name)
            if section is None or other is None:
                continue
            now = set(_indices(other.numbered()))
            for _, entry in section.numbered():
                there = parse(entry.value)
                if entry.value and (there is None or there.value not in now):
                    what = f"{entry.value[:_SHORT]} is no more in [{section.name}]"
                    yield self._note(entry.span, what, "it is in the list of its range")
            count, counted = (each.get("SupportedObjects") for each in (section, other))
            if (
                count is not None
                and counted is not None
                and count.value != counted.value
            ):
                what = f"[{section.name}] counts {counted.value} now"
                yield self._note(count.span, what, "its entries are others")


def _indices(entries: Iterable[tuple[int, Entry]]) -> Iterator[int]:
    parsed = (parse(entry.value) for _, entry in entries)
    return (index.value for index in parsed if index is not None)


def _same(one: str, other: str, default: str = "") -> bool:
    """Return whether two values are the same, or the same number, in another notation."""
    if one.lower() == other.lower() or (not other and _same_number(one, default)):
        return True
    return _same_number(one, other) or _plain(one) == _plain(other)


def _same_number(one: str, other: str) -> bool:
    numbers = parse(one), parse(other)
    if numbers[0] is not None and numbers[1] is not None:
        apart = abs(numbers[0].value - numbers[1].value)
        return (not apart or apart in _WRAPS) and not numbers[0].odd
    try:
        return float(one) == float(other)
    except ValueError:
        return False


def _plain(value: str) -> str:
    """Return a formula or octets without spaces, and with its numbers in decimal digits."""
    text = re.sub(r"\s+", "", value).upper()
    if "$" not in text:
        return text
    return _NUMBER.sub(lambda match: str(int(match[0], 0)), text)
