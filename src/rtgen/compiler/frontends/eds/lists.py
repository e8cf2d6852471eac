"""Sections that are lists with a count: lists of objects (CiA 306, 4.6.2) and others."""

from __future__ import annotations

from collections.abc import Collection

from rtgen.compiler.diagnostics import Span
from rtgen.compiler.frontends.eds.findings import Findings
from rtgen.compiler.frontends.eds.ini import Document, Entry, Section
from rtgen.compiler.frontends.eds.numbers import number, parse
from rtgen.compiler.frontends.eds.outline import LISTS, Outline
from rtgen.compiler.frontends.eds.rules import information
from rtgen.compiler.model.canopen import Object

MANDATORY = (0x1000, 0x1001, 0x1018)
"""The objects that are mandatory in every device."""


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
    right = LISTS[1]
    if index in MANDATORY:
        right = LISTS[0]
    elif 0x2000 <= index <= 0x5FFF:
        right = LISTS[2]
    if name != right and index >= 0x1000:
        kind = right.removesuffix("objects")
        message = f"{index:04X}h is one of the {kind} objects"
        findings.add(information.WRONG_LIST, span, message)
