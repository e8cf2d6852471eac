"""Descriptions in XML (XDD and XDC, CiA 311), read as the sections of CiA 306.

The places of sections and keys are those of elements and attributes, so all checks of the front
end apply, with the lines and columns of the XML.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping

import msgspec

from rtgen.compiler.diagnostics import InputError, Span
from rtgen.compiler.frontends.eds import ini
from rtgen.compiler.frontends.eds.findings import Findings
from rtgen.compiler.frontends.eds.ini import Document, Entry, Section
from rtgen.compiler.frontends.eds.lists import list_of
from rtgen.compiler.frontends.eds.outline import LISTS, PLAIN
from rtgen.compiler.frontends.eds.rules import lexical
from rtgen.compiler.frontends.eds.rules import xml as rules
from rtgen.compiler.frontends.eds.xdd_objects import Parameters, variable
from rtgen.compiler.frontends.eds.xml_elements import Elements, line
from rtgen.compiler.frontends.kit import located_xml
from rtgen.compiler.frontends.kit.located_xml import Element
from rtgen.compiler.typemap.canopen.xdd import (
    CONTAINER,
    DEVICE_BODY,
    EXTENSION,
    FIELDS,
    NAMESPACES,
    NETWORK_BODY,
    XSI,
    Body,
    rate_in,
)

_PROJECTS = ("CanOpenProject_1_1", "OpenEDSProject")
_INDEX = re.compile("(?:0[xX])?([0-9A-Fa-f]{1,4})")
_SUBINDEX = re.compile("(?:0[xX])?([0-9A-Fa-f]{1,2})")
_DUMMY = re.compile(r"(Dummy[0-9A-Fa-f]{4})\s*=\s*([01])", re.IGNORECASE)
_VERSION = re.compile(r"\s*([0-9]+)(?:\.([0-9]+))?\s*")
_COUNTS = dict(
    zip(
        LISTS,
        ("mandatoryObjects", "optionalObjects", "manufacturerObjects"),
        strict=True,
    )
)


def read(data: bytes, file: str, findings: Findings) -> Document:
    """Return the sections that a description in XML has; `file` is the path in diagnostics."""
    document = Document(file, "", {}, inline=True)
    if len(data) > ini.MAX_BYTES:
        findings.report(ini.too_large(file))
        return document
    try:
        document.text = located_xml.decode(data, file)
        root = located_xml.parse(document.text, file, _hint(document.text))
    except InputError as error:
        for diagnostic in error.diagnostics:
            findings.report(diagnostic)
        return document
    _Reader(document, findings, Elements(findings, root.name[0])).run(root)
    return document


def _hint(text: str) -> str:
    """Return what to do with a text that is no XML at all."""
    if text.lstrip("\ufeff \t\r\n").startswith(("[", ";")):
        return "this is an EDS or DCF: call it *.eds or *.dcf"
    return "XDD and XDC are XML (CiA 311)"


class _Reader(msgspec.Struct, eq=False):
    """Adds the sections of one file to its document."""

    _document: Document
    _findings: Findings
    _elements: Elements
    _places: list[tuple[int, str]] = []

    def run(self, root: Element) -> None:
        if not self._is_container(root):
            return
        bodies = self._bodies(root)
        network = bodies.get(Body.NETWORK)
        if network is None:
            self._missing(root, f"a profile with a {NETWORK_BODY}")
            return
        layers = self._elements.first(network, "ApplicationLayers")
        listed = layers and self._elements.first(layers, "CANopenObjectList")
        if layers is None or listed is None:
            self._missing(layers or network, "a CANopenObjectList")
            return
        device = bodies.get(Body.DEVICE)
        if device is None:
            message = f"there is no profile with a {DEVICE_BODY}: no vendor, no product"
            self._findings.add(rules.MISSING_PART, root.span, message)
        self._information(bodies)
        self._network(network, layers)
        process = device and self._elements.first(device, "ApplicationProcess")
        self._objects(listed, Parameters(self._elements, self._findings, process))
        if device is not None:
            self._extensions(device)
        for body in bodies.values():
            self._places += [(each.span.line, each.name[1]) for each in body.children]
        self._places.sort()
        self._document.headers = self._places

    def _is_container(self, root: Element) -> bool:
        namespace, name = root.name
        if name != CONTAINER:
            message = f"the root element is {name}, not {CONTAINER} of CiA 311"
            hint = f"an XDD begins with <{CONTAINER} xmlns={NAMESPACES[0]!r}>"
            if name in _PROJECTS:
                hint = "a project has several devices: export each of them as an XDD"
            self._findings.add(lexical.NO_DEVICE, root.span, message, hint=hint)
            return False
        if "powerlink" in namespace.lower():
            message = "this is a description for Ethernet POWERLINK, not for CANopen"
            hint = "the two have no more in common than the suffix and the container"
            self._findings.add(lexical.NO_DEVICE, root.span, message, hint=hint)
            return False
        if namespace not in NAMESPACES:
            self._elements.warn(root)
        return True

    def _missing(self, element: Element, part: str) -> None:
        message = f"there is no {part.removeprefix('a ')}"
        hint = f"the objects of a device are in {part} (CiA 311)"
        self._findings.add(lexical.NO_DEVICE, element.span, message, hint=hint)

    def _bodies(self, root: Element) -> dict[Body, Element]:
        """Return the profiles' bodies by their types, or by what they contain."""
        found: dict[Body, Element] = {}
        profiles = [*self._elements.all(root, "ISO15745Profile"), root]
        for body in [b for p in profiles for b in self._elements.all(p, "ProfileBody")]:
            type_ = body.get(XSI, "type").rpartition(":")[2]
            named = [kind for kind in Body if kind.value == type_]
            if not named:
                is_network = self._elements.has(body, "ApplicationLayers")
                named = [Body.NETWORK if is_network else Body.DEVICE]
                message = f"xsi:type is {type_!r}; this is taken for a {named[0].value}"
                at = body.place("type")
                self._findings.add(rules.MISSING_PART, at, message)
            found.setdefault(named[0], body)
        return found

    def _section(self, name: str, span: Span) -> Section:
        return self._document.sections.setdefault(name.lower(), Section(name, span))

    def _add(self, section: Section, key: str, value: str, at: Span) -> None:
        if value:
            section.entries.setdefault(key.lower(), entry_at(at, key, value))

    def _information(self, bodies: Mapping[Body, Element]) -> None:
        """Add what is one attribute or element each, and the version of the file."""
        for field in FIELDS:
            body = bodies.get(field.body)
            found = None if body is None else self._elements.at(body, field.path)
            if found is None or body is None:
                continue
            section = self._section(field.section, (found if field.path else body).span)
            if field.attribute:
                for name in filter(None, (field.attribute, field.other)):
                    value = field.read(found.get("", name).strip())
                    self._add(section, field.key, value, found.place(name))
            else:
                self._add(section, field.key, field.read(line(found.text)), found.span)
        first = bodies.get(Body.DEVICE) or bodies[Body.NETWORK]
        section = self._section("FileInfo", first.span)
        version, at = first.get("", "fileVersion"), first.place("fileVersion")
        match = _VERSION.fullmatch(version)
        self._add(section, "FileVersion", match[1] if match else version, at)
        self._add(section, "FileRevision", (match and match[2]) or "0", at)
        self._add(section, "EDSVersion", "4.0", at)

    def _network(self, network: Element, layers: Element) -> None:
        """Add bit rates, gaps, and the identity of a description without a device profile."""
        find = self._elements
        info = self._section("DeviceInfo", network.span)
        rates = find.at(network, ("TransportLayers", "PhysicalLayer", "baudRate"))
        for rate in find.all(rates, "supportedBaudRate"):
            number = rate_in(rate.get("", "value"))
            if number.isdigit():
                self._add(info, f"BaudRate_{number}", "1", rate.place("value"))
        for dummy in find.all(find.first(layers, "dummyUsage"), "dummy"):
            match = _DUMMY.fullmatch(dummy.get("", "entry").strip())
            at = dummy.place("entry")
            if match is None:
                message = "the entry of a dummy is DummyNNNN=0 or DummyNNNN=1"
                self._findings.add(rules.BAD_PART, at, message)
                continue
            self._add(self._section("DummyUsage", dummy.span), match[1], match[2], at)
        for name, key in (("vendorID", "VendorNumber"), ("productID", "ProductNumber")):
            element = find.at(layers, ("identity", name))
            if element is not None:
                self._add(info, key, line(element.text), element.span)
        for name in ("moduleManagement", "dynamicChannels"):
            element = find.first(layers, name)
            if element is not None:
                message = f"{name} is not read: its objects are missing"
                self._findings.add(rules.NOT_READ, element.span, message)

    def _objects(self, listed: Element, parameters: Parameters) -> None:
        lists = {name: self._section(PLAIN[name], listed.span) for name in LISTS}
        counts = dict.fromkeys(LISTS, 0)
        for element in self._elements.all(listed, "CANopenObject"):
            index = self._number(element, "index", _INDEX, "4 hexadecimal digits")
            head = None if index is None else self._new(f"{index:04X}", element)
            if index is None or head is None:
                continue
            name = list_of(index)
            counts[name] += 1
            at = element.place("index")
            self._add(lists[name], str(counts[name]), f"0x{index:04X}", at)
            own = parameters.of(element)
            self._fill(head, variable(element, own, parameters))
            self._mark(head.name, own)
            subs = list(self._elements.all(element, "CANopenSubObject"))
            for position, sub in enumerate(subs):
                number = self._number(sub, "subIndex", _SUBINDEX, "2 of these digits")
                below = None if number is None else f"{index:04X}sub{number:X}"
                section = None if below is None else self._new(below, sub)
                if section is None:
                    continue
                its = parameters.of(sub)
                member = parameters.member(own, position)
                self._fill(section, variable(sub, its, parameters, member))
                self._mark(section.name, its)
        for name, section in lists.items():
            attribute = _COUNTS[name]
            declared = listed.get("", attribute) or str(counts[name])
            self._add(section, "SupportedObjects", declared, listed.place(attribute))

    def _new(self, name: str, element: Element) -> Section | None:
        """Return the section of an object; None, with a warning, if there is one already."""
        first = self._document.sections.get(name.lower())
        if first is not None:
            message = f"{name} is described in line {first.span.line} already"
            self._findings.add(lexical.SAME_SECTION, element.span, message)
            return None
        self._places.append((element.span.line, name))
        return self._section(name, element.span)

    def _mark(self, name: str, parameter: Element | None) -> None:
        if parameter is not None:
            self._places.append((parameter.span.line, name))

    def _fill(self, section: Section, entries: Iterator[tuple[str, str, Span]]) -> None:
        for key, value, at in entries:
            self._add(section, key, value, at)

    def _number(
        self, element: Element, attribute: str, form: re.Pattern[str], expectation: str
    ) -> int | None:
        text = element.get("", attribute).strip()
        match = form.fullmatch(text)
        if match is None:
            what = f"{text[:20]!r}, not {expectation}" if text else "missing"
            message = f"{attribute} is {what}; the {element.name[1]} is ignored"
            at = element.place(attribute)
            self._findings.add(rules.BAD_PART, at, message)
            return None
        return int(match[1], 16)

    def _extensions(self, device: Element) -> None:
        """Set the keys that are characteristics, since CiA 311 has no element for them."""
        find = self._elements
        for function in find.all(device, "DeviceFunction"):
            capabilities = find.first(function, "capabilities")
            for each in find.all(capabilities, "characteristicsList"):
                for characteristic in find.all(each, "characteristic"):
                    name = find.text(find.first(characteristic, "characteristicName"))
                    match = EXTENSION.fullmatch(name)
                    if match is None:
                        continue
                    content = find.first(characteristic, "characteristicContent")
                    at = characteristic.span if content is None else content.span
                    section, key = self._section(match[1], at), match[2]
                    section.entries[key.lower()] = entry_at(at, key, find.text(content))


def entry_at(at: Span, key: str, value: str) -> Entry:
    """Return an entry with its value at a place."""
    return Entry(at.file, at.line, at.column, key, value, at.column)
