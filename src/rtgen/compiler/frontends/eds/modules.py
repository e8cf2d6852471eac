"""Modular devices: objects added by the modules in the slots (CiA 306, 4.7)."""

from __future__ import annotations

from collections.abc import Sequence

from msgspec.structs import replace

from rtgen.compiler.frontends.eds.findings import Findings
from rtgen.compiler.frontends.eds.ini import Section
from rtgen.compiler.frontends.eds.lists import check_count
from rtgen.compiler.frontends.eds.numbers import number, parse
from rtgen.compiler.frontends.eds.objects import ObjectReader
from rtgen.compiler.frontends.eds.outline import ModuleSections, Outline
from rtgen.compiler.frontends.eds.rules import modules as rules
from rtgen.compiler.frontends.eds.variables import VariableReader
from rtgen.compiler.model.canopen import Module, Object, ObjectType, Variable

_MAX_SUBINDEX = 254
_MAX_SLOTS = 254


class ModuleReader:
    """Reads the modules of one file, and applies the connected ones."""

    def __init__(self, outline: Outline, findings: Findings, dcf: bool) -> None:
        self._outline = outline
        self._findings = findings
        self._dcf = dcf

    def kinds(self) -> tuple[Module, ...]:
        """Return the module types that the device supports."""
        section = self._outline.plain.get("supportedmodules")
        count = 0
        if section is not None:
            entry = section.get("NrOfEntries")
            declared = None if entry is None else number(entry, self._findings)
            count = declared if declared is not None and declared >= 0 else 0
        for key, sections in sorted(self._outline.modules.items()):
            if not 1 <= key <= count and sections.first is not None:
                message = f"[SupportedModules] counts {count} modules, not module {key}"
                self._findings.add(rules.NO_MODULE, sections.first.span, message)
        return tuple(
            Module(key, info.text("ProductName"), info.text("OrderCode"))
            for key, sections in sorted(self._outline.modules.items())
            if (info := sections.info) is not None
        )

    def connected(self) -> tuple[int, ...]:
        """Return the numbers of the modules in the slots, in order."""
        section = self._outline.plain.get("connectedmodules")
        if section is None:
            return ()
        entries = sorted(section.numbered(), key=lambda pair: pair[0])[:_MAX_SLOTS]
        check_count(section, "NrOfEntries", len(entries), self._findings)
        modules = []
        for _, entry in entries:
            declared = parse(entry.value)
            if declared is None or declared.value not in self._outline.modules:
                message = f"there is no module {entry.value[:20]}"
                self._findings.add(rules.NO_MODULE, entry.span, message)
            else:
                modules.append(declared.value)
        return tuple(modules)

    def apply(self, objects: list[Object], connected: Sequence[int]) -> list[Object]:
        """Return the object dictionary extended by the modules."""
        dictionary = {o.index: o for o in objects}
        for key in connected:
            sections = self._outline.modules[key]
            reader = ObjectReader(sections.fixed, self._findings, self._dcf)
            for added in reader.read():
                dictionary.setdefault(added.index, added)
            self._extend(dictionary, sections)
        return [dictionary[index] for index in sorted(dictionary)]

    def _extend(self, dictionary: dict[int, Object], sections: ModuleSections) -> None:
        for index, section in sorted(sections.extensions.items()):
            count = self._count(section)
            entry = section.get("ObjExtend")
            step = parse(entry.value) if entry is not None else None
            reader = VariableReader(self._findings, {}, self._dcf)
            name = reader.name(section, f"Object {index:04X}h") if count else ""
            one = reader.read(section, index, 1, name) if count else None
            for _ in range(count if one is not None else 0):
                assert one is not None
                if not _append(dictionary, index, one, step.value if step else 0):
                    message = f"there is no room for it in {index:04X}h"
                    self._findings.add(rules.NOTHING_TO_EXTEND, section.span, message)
                    break

    def _count(self, section: Section) -> int:
        """Return the number of sub-objects that a module adds; for a list by type, their sum."""
        entry = section.get("Count")
        if entry is None:
            return 1
        whole = entry.value.replace(";", ",").split(",")
        counts = [parse(text.strip()) for text in whole[:_MAX_SUBINDEX]]
        return min(_MAX_SLOTS, sum(c.value for c in counts if c and c.value > 0))


def _append(
    dictionary: dict[int, Object], index: int, one: Variable, step: int
) -> bool:
    """Append a sub-object, to a further object if this one is full."""
    while (of := dictionary.get(index)) is not None:
        if of.type not in (ObjectType.ARRAY, ObjectType.RECORD):
            return False
        last = max((v.subindex for v in of.variables), default=0)
        if last < _MAX_SUBINDEX:
            added = replace(
                one, index=index, subindex=last + 1, name=f"{one.name}{last + 1}"
            )
            counted = tuple(
                replace(v, default=last + 1) if v.subindex == 0 else v
                for v in of.variables
            )
            dictionary[index] = replace(of, variables=(*counted, added))
            return True
        if step <= 0 or index + step > 0xFFFF:
            return False
        index += step
    return False
