"""Compact sub-objects (CiA 306, 4.6.4): one section for all members, lists for the differences."""

from __future__ import annotations

from collections.abc import Mapping

from msgspec.structs import replace

from rtgen.compiler.frontends.eds import numbers
from rtgen.compiler.frontends.eds.findings import Findings
from rtgen.compiler.frontends.eds.ini import Section
from rtgen.compiler.frontends.eds.lists import check_count
from rtgen.compiler.frontends.eds.outline import ObjectSections
from rtgen.compiler.frontends.eds.rules import objects as rules
from rtgen.compiler.frontends.eds.variables import VariableReader
from rtgen.compiler.model.canopen import (
    MAPPINGS,
    Access,
    DataType,
    Object,
    ObjectType,
    Variable,
)

MAX_SUBINDEX = 254


def expand(
    head: Section,
    index: int,
    name: str,
    sections: ObjectSections,
    reader: VariableReader,
    findings: Findings,
) -> dict[int, Variable]:
    """Return the members described by CompactSubObj, by sub-index; empty without it."""
    entry = head.get("CompactSubObj")
    count = None if entry is None else numbers.number(entry, findings)
    if entry is None:
        return {}
    if count is None or not 0 <= count <= MAX_SUBINDEX:
        taken = MAX_SUBINDEX if count is not None and count > MAX_SUBINDEX else 0
        message = f"CompactSubObj is {entry.value[:20]}, not 0 to {MAX_SUBINDEX}"
        findings.add(rules.COMPACT_COUNT, entry.span, message)
        count = taken
    subs = head.get("SubNumber")
    if count and subs is not None and numbers.parse(subs.value) != numbers.Number(0):
        message = "SubNumber and CompactSubObj exclude each other"
        findings.add(rules.COMPACT_COUNT, subs.span, message)
    if not count:
        return {}
    one = reader.read(head, index, 1, name)
    if one is None:
        return {}
    # A mapping is changed by writing its sub-index 0 (CiA 301, 7.5.2.36), so that is writable.
    mapping = index in MAPPINGS and one.access.writable
    first = Variable(
        index=index,
        subindex=0,
        name="Highest sub-index supported",
        data_type=DataType.UNSIGNED8,
        access=Access.RW if mapping else Access.RO,
        written_access=Access.RO.value,
        span=head.span,
        value_span=entry.span,
        default=count,
    )
    variables = {0: first}
    for subindex in range(1, count + 1):
        variables[subindex] = replace(one, subindex=subindex, name=f"{name}{subindex}")
    names = sections.names.get(index)
    for subindex, entry in () if names is None else names.numbered():
        if subindex in variables and entry.value:
            variables[subindex] = replace(variables[subindex], name=entry.value)
    return variables


def configure(
    members: dict[int, Variable],
    index: int,
    sections: ObjectSections,
    reader: VariableReader,
    findings: Findings,
) -> None:
    """Set values and denotations from the lists, for members without their own."""
    values = sections.values.get(index)
    if values is not None:
        reader.warn_of_dcf(values, whole=True)
        for subindex, entry in values.numbered():
            variable = members.get(subindex)
            if variable is not None and variable.value is None and entry.value:
                declared = numbers.value(entry, variable.data_type, findings)
                members[subindex] = replace(
                    variable, value=declared, value_span=entry.span
                )
    names = sections.denotations.get(index)
    for subindex, entry in () if names is None else names.numbered():
        variable = members.get(subindex)
        if variable is not None and not variable.denotation:
            members[subindex] = replace(variable, denotation=entry.value)


def check_lists(
    sections: ObjectSections, objects: Mapping[int, Object], findings: Findings
) -> None:
    """Report lists and entries of lists without a compact sub-object."""
    for lists in (sections.names, sections.values, sections.denotations):
        for index, section in lists.items():
            _check_list(section, objects.get(index), findings)


def _check_list(section: Section, of: Object | None, findings: Findings) -> None:
    composed = of is not None and of.type in (ObjectType.ARRAY, ObjectType.RECORD)
    if of is None or not composed:
        message = f"[{section.name}] belongs to no ARRAY or RECORD"
        findings.add(rules.NOT_COMPACT, section.span, message)
        return
    subindices = {v.subindex for v in of.variables}
    entries = dict(section.numbered())
    for subindex, entry in entries.items():
        if subindex not in subindices:
            message = f"{of.name} has no sub-index {subindex}"
            findings.add(rules.NOT_COMPACT, entry.key_span, message)
    check_count(section, "NrOfEntries", len(entries), findings)
