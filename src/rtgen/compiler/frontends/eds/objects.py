"""Reads objects and their variables from sections (CiA 306, 4.6)."""

from __future__ import annotations

from collections.abc import Iterator

from rtgen.compiler.frontends.eds import compact, variables
from rtgen.compiler.frontends.eds.findings import Findings
from rtgen.compiler.frontends.eds.ini import Section
from rtgen.compiler.frontends.eds.lists import index_of
from rtgen.compiler.frontends.eds.numbers import number, parse
from rtgen.compiler.frontends.eds.outline import ObjectSections
from rtgen.compiler.frontends.eds.rules import information, lexical
from rtgen.compiler.frontends.eds.rules import objects as rules
from rtgen.compiler.frontends.eds.variables import VariableReader
from rtgen.compiler.kit.limits import MAX_VARIABLES, MAX_WRITTEN_VARIABLES
from rtgen.compiler.model.canopen import DataType, Object, ObjectType, Variable

_MAX_INDEX = 0xBFFF
_TYPES_END = 0x1000
_COUNT_OTHER_THINGS = (
    *range(0x1600, 0x1800),
    *range(0x1A00, 0x1C00),
    0x1003,
    0x1010,
    0x1011,
    0x1016,
)


class ObjectReader:
    """Reads the objects of one file."""

    def __init__(self, sections: ObjectSections, findings: Findings, dcf: bool) -> None:
        self._sections = sections
        self._findings = findings
        self._variables = VariableReader(findings, self._defined_types(sections), dcf)
        self._room = MAX_VARIABLES
        self._whole_room = MAX_WRITTEN_VARIABLES

    def read(self) -> list[Object]:
        """Return the objects by index, without DEFTYPE, DEFSTRUCT and NULL."""
        sections = self._sections
        objects = []
        for index in sorted({*sections.heads, *sections.subs}):
            if index >= _TYPES_END:
                object_ = self._object(index)
                objects += [object_] if object_ is not None else []
            if self._room < 0 or self._whole_room < 0:
                subs = sections.subs.get(index, {})
                places = (sections.heads.get(index), *subs.values())
                span = min(place.span for place in places if place is not None)
                message = (
                    f"the objects have more than {MAX_VARIABLES:,} variables by counts"
                    if self._room < 0
                    else f"the objects have more than {MAX_WRITTEN_VARIABLES:,} variables"
                )
                self._findings.add(lexical.TOO_MANY_OBJECTS, span, message)
                return []
        by_index = {o.index: o for o in objects}
        compact.check_lists(sections, by_index, self._findings)
        return objects

    @staticmethod
    def _defined_types(sections: ObjectSections) -> dict[int, int]:
        """Return the types defined by the file as subranges of basic types: code to basic code."""
        defined = {}
        for index, subs in sections.subs.items():
            base = subs[1].get("DefaultValue") if 1 in subs else None
            declared = None if base is None else parse(base.value)
            if (
                index < _TYPES_END
                and declared is not None
                and declared.value in variables.KNOWN
            ):
                defined[index] = declared.value
        return defined

    def _object(self, index: int) -> Object | None:
        head = self._sections.heads.get(index)
        subs = self._sections.subs.get(index, {})
        if head is None:
            first = min(subs.values(), key=lambda s: s.span)
            head = Section(f"{index:04X}", first.span)
            message = f"there is no section [{index:04X}]; a RECORD is assumed"
            self._findings.add(rules.ORPHAN, first.span, message)
            type_: ObjectType = ObjectType.RECORD
            name = f"Object {index:04X}h"
        else:
            type_ = self._type(head, subs)
            name = self._variables.name(head, f"Object {index:04X}h")
        if type_ in (ObjectType.NULL, ObjectType.DEFTYPE, ObjectType.DEFSTRUCT):
            return None
        if index > _MAX_INDEX:
            message = f"{index:04X}h is a reserved index"
            self._findings.add(rules.RESERVED_INDEX, head.span, message)
        if type_ in (ObjectType.VAR, ObjectType.DOMAIN):
            for sub in subs.values():
                message = (
                    f"{name} is a variable and has no sub-objects; this one is ignored"
                )
                self._findings.add(rules.OF_A_VAR, sub.span, message)
            variable = self._variables.read(
                head, index, 0, name, domain=type_ is ObjectType.DOMAIN
            )
            members = [variable] if variable is not None else []
        else:
            members = self._members(head, index, name, type_, subs)
        self._room -= max(0, len(members) - len(subs) - 1)
        self._whole_room -= len(members)
        return Object(
            index=index,
            name=name,
            type=type_,
            variables=tuple(members),
            span=head.span,
            denotation=head.text("Denotation"),
            flags=self._variables.flags(head),
            links=tuple(self._links(index)),
        )

    def _type(self, head: Section, subs: dict[int, Section]) -> ObjectType:
        """Return the type in ObjectType, falling back on the other keys."""
        entry = head.get("ObjectType")
        written = None if entry is None else self._variables.word(entry, ObjectType)
        declared = ObjectType(written) if written in set(ObjectType) else None
        composed = bool(subs) or head.get("CompactSubObj") is not None
        typed = head.get("DataType") is not None
        if declared is ObjectType.VAR or (entry is None and typed):
            likely = ObjectType.VAR if typed or not composed else ObjectType.RECORD
        elif declared is not None:
            return declared
        elif typed and not composed:
            likely = ObjectType.VAR
        else:
            likely = ObjectType.RECORD if composed else ObjectType.VAR
        if likely is not (declared or (ObjectType.VAR if entry is None else None)):
            span = head.span if entry is None else entry.span
            message = f"ObjectType is taken for {likely.name}"
            self._findings.add(rules.OBJECT_TYPE, span, message)
        return likely

    def _members(
        self,
        head: Section,
        index: int,
        name: str,
        type_: ObjectType,
        subs: dict[int, Section],
    ) -> list[Variable]:
        members = compact.expand(
            head, index, name, self._sections, self._variables, self._findings
        )
        common = None if type_ is ObjectType.RECORD else self._common_type(head, subs)
        for subindex in sorted(subs):
            fallback = f"{name}{subindex}"
            section = subs[subindex]
            variable = self._variables.read(
                section,
                index,
                subindex,
                self._variables.name(section, fallback),
                common=common,
            )
            if variable is not None:
                members[subindex] = variable
        compact.configure(
            members, index, self._sections, self._variables, self._findings
        )
        self._check_members(head, type_, members, len(subs))
        return [members[subindex] for subindex in sorted(members)]

    def _common_type(self, head: Section, subs: dict[int, Section]) -> int | None:
        """Return the data type of an ARRAY's members: the head's, else the first one given."""
        for section in (head, *(subs[k] for k in sorted(subs) if k)):
            entry = section.get("DataType")
            declared = None if entry is None else parse(entry.value)
            if declared is not None:
                return declared.value
        return None

    def _check_members(
        self,
        head: Section,
        type_: ObjectType,
        variables: dict[int, Variable],
        described: int,
    ) -> None:
        if not variables:
            message = f"this {type_.name} has no sub-objects"
            self._findings.add(rules.NO_SUBS, head.span, message)
            return
        entry = head.get("SubNumber")
        declared = None if entry is None else number(entry, self._findings)
        if entry is not None and declared != described and described:
            message = f"SubNumber is {entry.value[:20]}; {described} sub-objects are described"
            self._findings.add(rules.SUB_NUMBER, entry.span, message)
        first = variables.get(0)
        if first is None:
            message = f"this {type_.name} has no sub-index 0"
            self._findings.add(rules.NO_SUB0, head.span, message)
        else:
            self._check_first(first, max((k for k in variables if k < 0xFF), default=0))
        if type_ is ObjectType.ARRAY:
            members = [v for k, v in sorted(variables.items()) if 0 < k < 0xFF]
            for member in members[1:]:
                if member.data_type != members[0].data_type:
                    message = (
                        f"sub-index {member.subindex} is not {type_text(members[0])}, "
                        "as the first one"
                    )
                    self._findings.add(rules.ARRAY_TYPES, member.span, message)
                    break

    def _check_first(self, first: Variable, highest: int) -> None:
        if first.data_type != DataType.UNSIGNED8:
            message = f"sub-index 0 is not UNSIGNED8, but {type_text(first)}"
            self._findings.add(rules.SUB0_TYPE, first.span, message)
        declared = first.default
        if first.index in _COUNT_OTHER_THINGS or not isinstance(declared, int):
            return
        if declared != highest:
            message = f"sub-index 0 is {declared}; the highest described is {highest}"
            self._findings.add(rules.SUB0_VALUE, first.value_span, message)

    def _links(self, index: int) -> Iterator[int]:
        section = self._sections.links.get(index)
        if section is None:
            return
        entries = dict(section.numbered())
        for key in sorted(entries):
            declared = index_of(entries[key])
            if declared is None:
                message = f"{entries[key].value[:40]} is not an index"
                self._findings.add(information.BAD_ENTRY, entries[key].span, message)
            else:
                yield declared


def type_text(variable: Variable) -> str:
    """Return the name of a variable's data type."""
    code = variable.data_type
    return DataType(code).name if code in variables.KNOWN else f"type {code:04X}h"
