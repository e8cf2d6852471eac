"""Sorts the sections of a file by kind, according to their names (CiA 306, 4.5 to 4.8)."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import TypeVar

import msgspec

from rtgen.compiler.frontends.eds.findings import Findings
from rtgen.compiler.frontends.eds.ini import Document, Section
from rtgen.compiler.frontends.eds.rules import lexical, objects

COMMISSIONING = "devicecomissioning"
LISTS = ("mandatoryobjects", "optionalobjects", "manufacturerobjects")

K = TypeVar("K")

_OTHER_NAMES = {"devicecommissioning": COMMISSIONING}

PLAIN = {
    "fileinfo": "FileInfo",
    "deviceinfo": "DeviceInfo",
    COMMISSIONING: "DeviceComissioning",
    "dummyusage": "DummyUsage",
    "comments": "Comments",
    "mandatoryobjects": "MandatoryObjects",
    "optionalobjects": "OptionalObjects",
    "manufacturerobjects": "ManufacturerObjects",
    "supportedmodules": "SupportedModules",
    "connectedmodules": "ConnectedModules",
    "dynamicchannels": "DynamicChannels",
    "tools": "Tools",
}
"""Sections with fixed names, by lower-case name."""

_OBJECT = re.compile(
    r"(0x)?([0-9a-f]{2,4})(?:sub([0-9a-f]{1,8})|(name|value|denotation|objectlinks))?"
)
_MODULE = re.compile(r"m([0-9]{1,5})(moduleinfo|comments|fixedobjects|subextends|"
                     r"fixed|subext)(.*)")  # fmt: skip
_TOOL = re.compile(r"tool[0-9]+")


class ObjectSections(msgspec.Struct, eq=False):
    """The sections of objects, by index and sub-index."""

    heads: dict[int, Section] = msgspec.field(default_factory=dict)
    subs: dict[int, dict[int, Section]] = msgspec.field(default_factory=dict)
    names: dict[int, Section] = msgspec.field(default_factory=dict)
    values: dict[int, Section] = msgspec.field(default_factory=dict)
    denotations: dict[int, Section] = msgspec.field(default_factory=dict)
    links: dict[int, Section] = msgspec.field(default_factory=dict)

    def all(self) -> Iterator[Section]:
        """Yield the sections that describe an object or a sub-object."""
        yield from self.heads.values()
        for subs in self.subs.values():
            yield from subs.values()


class ModuleSections(msgspec.Struct, eq=False):
    """The sections of a module type."""

    info: Section | None = None
    fixed: ObjectSections = msgspec.field(default_factory=ObjectSections)
    extensions: dict[int, Section] = msgspec.field(default_factory=dict)
    first: Section | None = None


class Outline(msgspec.Struct, eq=False):
    """All sections of a file by their kind."""

    plain: dict[str, Section] = msgspec.field(default_factory=dict)
    objects: ObjectSections = msgspec.field(default_factory=ObjectSections)
    modules: dict[int, ModuleSections] = msgspec.field(default_factory=dict)
    further: list[Section] = msgspec.field(default_factory=list)


def standard_name(name: str) -> str:
    """Return the name that CiA 306 has for a section of a name, in lower case."""
    plain = _OTHER_NAMES.get(name.lower(), name.lower())
    match = _OBJECT.fullmatch(plain)
    if match is None or (len(match[2]) < 4 and not match[1]):
        return plain
    sub = "" if match[3] is None else f"sub{int(match[3], 16):x}"
    return f"{int(match[2], 16):04x}{sub}{match[4] or ''}"


def outline(document: Document, findings: Findings) -> Outline:
    """Sort the sections of a file."""
    result = Outline()
    for name, section in document.sections.items():
        _place(name, section, result, findings)
    return result


def _place(name: str, section: Section, result: Outline, findings: Findings) -> None:
    plain = _OTHER_NAMES.get(name, name)
    if plain in PLAIN:
        if plain != name:
            _spelling(section, PLAIN[plain], findings)
        _keep(result.plain, plain, section, findings)
    elif _TOOL.fullmatch(name):
        result.plain[name] = section
    elif (match := _MODULE.fullmatch(name)) is not None:
        _place_module(match, section, result, findings)
    elif not _place_object(name, "", section, result.objects, findings):
        result.further.append(section)


def _place_module(
    match: re.Match[str], section: Section, result: Outline, findings: Findings
) -> None:
    module = result.modules.setdefault(int(match[1]), ModuleSections())
    module.first = module.first or section
    prefix = section.name[: match.start(3)]
    match match[2], match[3]:
        case "moduleinfo", "":
            module.info = section
        case "comments" | "fixedobjects" | "subextends", "":
            pass
        case "fixed", rest if _place_object(
            rest, prefix, section, module.fixed, findings
        ):
            pass
        case "subext", rest if re.fullmatch("[0-9a-f]{4}", rest):
            module.extensions[int(rest, 16)] = section
        case _:
            result.further.append(section)


def _place_object(
    name: str, prefix: str, section: Section, into: ObjectSections, findings: Findings
) -> bool:
    """Store the section if its name, after the prefix, is that of an object."""
    match = _OBJECT.fullmatch(name)
    if match is None:
        return False
    zero_x, digits, sub, kind = match.groups()
    if len(digits) < 4 and not (zero_x or any(c.isdigit() for c in digits)):
        return False
    index = int(digits, 16)
    subindex = None if sub is None else int(sub, 16)
    if subindex is not None and subindex > 0xFF:
        message = f"there is no sub-index {sub}; the section is ignored"
        findings.add(objects.BAD_SUBINDEX, section.span, message)
        return True
    padded = sub is not None and len(sub) > 1 and sub[0] == "0"
    if zero_x or len(digits) < 4 or padded:
        rest = "" if subindex is None else f"sub{subindex:X}"
        _spelling(section, f"{prefix}{index:04X}{rest}{(kind or '').title()}", findings)
    if subindex is not None:
        _keep(into.subs.setdefault(index, {}), subindex, section, findings)
        return True
    places = {
        None: into.heads,
        "name": into.names,
        "value": into.values,
        "denotation": into.denotations,
        "objectlinks": into.links,
    }
    _keep(places[kind], index, section, findings)
    return True


def _spelling(section: Section, standard: str, findings: Findings) -> None:
    message = f"[{section.name}] is taken for [{standard}]"
    findings.add(lexical.OTHER_SPELLING, section.span, message)


def _keep(
    places: dict[K, Section], key: K, section: Section, findings: Findings
) -> None:
    first = places.setdefault(key, section)
    if first is not section:
        message = f"[{first.name}] in line {first.span.line} is the same section"
        findings.add(lexical.SAME_SECTION, section.span, message)
        for name, entry in section.entries.items():
            first.entries.setdefault(name, entry)
