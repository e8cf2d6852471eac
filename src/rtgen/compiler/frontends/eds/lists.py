"""Sections that are lists with a count: lists of objects (CiA 306, 4.6.2) and others."""

from __future__ import annotations

import re
from collections.abc import Collection
from difflib import get_close_matches
from typing import Final

from rtgen.compiler.diagnostics import Span
from rtgen.compiler.frontends.eds.findings import Findings
from rtgen.compiler.frontends.eds.ini import Document, Entry, Section
from rtgen.compiler.frontends.eds.numbers import number, parse
from rtgen.compiler.frontends.eds.outline import LISTS, PLAIN, Outline
from rtgen.compiler.frontends.eds.rules import information, lexical
from rtgen.compiler.frontends.kit.suggestions import differ_in_one, nearest
from rtgen.compiler.model.canopen import Object

MANDATORY = (0x1000, 0x1001, 0x1018)
"""The objects that are mandatory in every device."""

_MAX_SUGGESTIONS: Final = 20
"""Maximum number of unknown sections with a suggestion."""
_LIKE_OBJECT: Final = re.compile(
    r"(?:0x)?([0-9A-Za-z]{4})(?:[ _.-]*([a-z]{2,5})[ _.-]*([0-9A-Za-z]{1,2}))?", re.I
)
_INDEX: Final = re.compile("[1-9A-F][0-9A-F]{3}")
_LIKE_SUB: Final = 0.6
_DIGITS: Final = str.maketrans("OoQlIiZzSs", "0001112255")
"""Letters that look like digits."""


def list_of(index: int) -> str:
    """Return the list that an object belongs to (CiA 306, 4.6.2)."""
    if index in MANDATORY:
        return LISTS[0]
    return LISTS[2] if 0x2000 <= index <= 0x5FFF else LISTS[1]


def check_count(section: Section, key: str, count: int, findings: Findings) -> None:
    """Report a missing count, or one that differs from the number of entries."""
    entry = section.get(key)
    if entry is None:
        message = f"{key} is missing; there are {count} entries"
        findings.add(information.WRONG_COUNT, section.span, message)
    elif number(entry, findings) != count:
        message = f"{key} is {entry.value[:20]}, and there are {count} entries"
        findings.add(information.WRONG_COUNT, entry.span, message)


def index_of(entry: Entry) -> int | None:
    """Return the index in an entry of a list; None if it is malformed."""
    declared = parse(entry.value.split()[0]) if entry.value else None
    return (
        declared.value
        if declared is not None and 0 <= declared.value <= 0xFFFF
        else None
    )


def check_unknown(outline: Outline, findings: Findings) -> None:
    """Report the sections that CiA 306 does not have, with what they were likely meant as."""
    missing = _undescribed(outline)
    for place, section in enumerate(outline.further):
        message = f"[{section.name}] is not a section of CiA 306"
        meant = None
        if place < _MAX_SUGGESTIONS:
            meant = _meant(section.name, missing) or nearest(
                section.name,
                [n for key, n in PLAIN.items() if key not in outline.plain],
            )
        if meant is None:
            findings.add(lexical.UNKNOWN_SECTION, section.span, message)
        else:
            message = f"{message}, and all in it is ignored"
            hint = f"did you mean [{meant}]?"
            findings.add(lexical.MISSPELT_SECTION, section.span, message, hint=hint)


def _undescribed(outline: Outline) -> list[str]:
    """Return the names of the sections that the lists of objects announce, and that are missing."""
    sections = (outline.plain.get(name) for name in LISTS)
    entries = (e for s in sections if s is not None for _, e in s.numbered() if e.value)
    indices = sorted({i for i in map(index_of, entries) if i is not None})
    return [f"{i:04X}" for i in indices if i not in outline.objects.heads]


def _meant(name: str, missing: Collection[str]) -> str | None:
    """Return the section of an object that a name likely denotes: `20OO`, `1018sup1`, `200G`."""
    match = _LIKE_OBJECT.fullmatch(name)
    if match is None:
        return None
    head, middle, sub = match.groups()
    index = head.translate(_DIGITS).upper()
    if middle and not get_close_matches(middle.lower(), ["sub"], cutoff=_LIKE_SUB):
        return None
    rest = f"sub{sub.translate(_DIGITS).upper()}" if middle else ""
    if _INDEX.fullmatch(index) is None:
        near = [each for each in missing if differ_in_one(each, index)]
        if len(near) != 1:
            return None
        index = near[0]
    return f"{index}{rest}" if f"{index}{rest}" != name else None


def check(
    document: Document,
    outline: Outline,
    objects: Collection[Object],
    findings: Findings,
) -> None:
    """Compare the lists of objects with the objects of the file."""
    described = {*outline.objects.heads, *outline.objects.subs}
    listed: set[int] = set()
    for name in LISTS:
        section = outline.plain.get(name)
        if section is None:
            continue
        entries = [(key, e) for key, e in section.numbered() if e.value]
        check_count(section, "SupportedObjects", len(entries), findings)
        for _, entry in entries:
            index = index_of(entry)
            if index is None:
                message = f"{entry.value[:40]} is not an index; it is ignored"
                findings.add(information.BAD_ENTRY, entry.span, message)
                continue
            _check_entry(name, index, entry.span, listed, described, findings)
            listed.add(index)
    if any(name in outline.plain for name in LISTS):
        for thing in objects:
            if thing.index not in listed:
                message = f"{thing.index:04X}h is in no list of objects"
                findings.add(information.NOT_LISTED, thing.span, message)
    missing = [f"{i:04X}h" for i in MANDATORY if i not in described]
    if missing:
        section = outline.plain.get(LISTS[0])
        span = document.start if section is None else section.span
        message = f"mandatory, but not described: {', '.join(missing)}"
        findings.add(information.MANDATORY_OBJECT, span, message)


def _check_entry(
    name: str,
    index: int,
    span: Span,
    listed: set[int],
    described: set[int],
    findings: Findings,
) -> None:
    if index in listed:
        message = f"{index:04X}h is listed twice"
        findings.add(information.LISTED_TWICE, span, message)
        return
    if index not in described:
        message = f"there is no section [{index:04X}]"
        findings.add(information.NOT_THERE, span, message)
    right = list_of(index)
    if name != right and index >= 0x1000:
        kind = right.removesuffix("objects")
        message = f"{index:04X}h is one of the {kind} objects"
        findings.add(information.WRONG_LIST, span, message)
