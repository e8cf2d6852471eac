"""Objects and their parameters in XML (CiA 311), as the keys of CiA 306.

An object has its properties as attributes (V1.0), or in a parameter that it refers to (V1.1).
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TypeAlias

from rtgen.compiler.diagnostics import Span
from rtgen.compiler.frontends.eds.findings import Findings
from rtgen.compiler.frontends.eds.numbers import parse
from rtgen.compiler.frontends.eds.rules import xml as rules
from rtgen.compiler.frontends.eds.xml_elements import Elements, line
from rtgen.compiler.frontends.kit.located_xml import Element
from rtgen.compiler.model.canopen import DataType
from rtgen.compiler.typemap.canopen.xdd import ACCESS, OCTETS, OTHER_TYPES, TYPES

_Entry: TypeAlias = tuple[str, str, Span]

_MAX_TYPES = 16
"""Maximum number of types that refer to each other."""
_NOT_MAPPABLE = ("", "no")
_ONE_WAY = {"TPDO": "rwr", "RPDO": "rww"}
_OF_PARAMETERS = (
    ("DefaultValue", "defaultValue"),
    ("ParameterValue", "actualValue"),
)


class Parameters:
    """The parameters and types of a device, by their identifiers."""

    def __init__(
        self, elements: Elements, findings: Findings, process: Element | None
    ) -> None:
        self.elements = elements
        self.findings = findings
        self._by_id: dict[str, Element] = {}
        types = elements.first(process, "dataTypeList")
        for kind in ("array", "struct", "enum", "derived"):
            self._note(elements.all(types, kind))
        templates = elements.first(process, "templateList")
        self._note(elements.all(templates, "parameterTemplate"))
        self._note(elements.all(elements.first(process, "parameterList"), "parameter"))

    def _note(self, found: Iterator[Element]) -> None:
        for element in found:
            name = element.get("", "uniqueID")
            first = self._by_id.setdefault(name, element)
            if first is not element and name:
                message = f"{name} is in line {first.span.line} already"
                at = element.place("uniqueID")
                self.findings.add(rules.SAME_ID, at, message)

    def of(self, element: Element) -> Element | None:
        """Return the parameter of an object; None, with a warning, if it is missing."""
        return self._referred(element, "uniqueIDRef")

    def _referred(self, element: Element, attribute: str) -> Element | None:
        name = element.get("", attribute)
        target = self._by_id.get(name)
        if name and target is None:
            message = f"there is no element with the identifier {name[:60]}"
            self.findings.add(rules.NO_TARGET, element.place(attribute), message)
        return target if name else None

    def chain(self, parameter: Element | None) -> list[Element]:
        """Return a parameter and its template; nothing without a parameter."""
        if parameter is None:
            return []
        template = self._referred(parameter, "templateIDRef")
        return [parameter] if template is None else [parameter, template]

    def member(self, parameter: Element | None, position: int) -> Element | None:
        """Return the declaration of the type of a sub-object, by that of its object."""
        for each in self.chain(parameter):
            reference = self.elements.first(each, "dataTypeIDRef")
            if reference is None:
                continue
            type_ = self._referred(reference, "uniqueIDRef")
            if type_ is None or type_.name[1] == "array":
                return type_ if position else None
            members = list(self.elements.all(type_, "varDeclaration"))
            return members[position] if position < len(members) else None
        return None

    def type_of(self, element: Element, is_valued: bool) -> DataType | None:
        """Return the data type that an element has, directly or by reference."""
        found: Element | None = element
        for _ in range(_MAX_TYPES):
            if found is None:
                return None
            for child in found.children:
                name = child.name[1]
                if name in TYPES:
                    return TYPES[name]
                if name in OTHER_TYPES:
                    return OTHER_TYPES[name]
                if name == OCTETS:
                    return DataType.OCTET_STRING if is_valued else DataType.DOMAIN
            reference = self.elements.first(found, "dataTypeIDRef")
            found = (
                None if reference is None else self._referred(reference, "uniqueIDRef")
            )
            if found is not None and found.name[1] in ("array", "struct"):
                return None
        return None


def variable(
    element: Element,
    parameter: Element | None,
    parameters: Parameters,
    member: Element | None = None,
) -> Iterator[_Entry]:
    """Yield the keys of an object or sub-object, with their values and places.

    `member` declares its type if it has none of its own.
    """
    return _Variable(element, parameters.chain(parameter), parameters, member).entries()


class _Variable:
    def __init__(
        self,
        element: Element,
        chain: list[Element],
        parameters: Parameters,
        member: Element | None,
    ) -> None:
        self._element = element
        self._chain = chain
        self._parameters = parameters
        self._find = parameters.elements
        self._member = member

    def entries(self) -> Iterator[_Entry]:
        yield self._name()
        yield self._attribute("ObjectType", "objectType")
        yield self._attribute("SubNumber", "subNumber")
        values = [self._value(key, name) for key, name in _OF_PARAMETERS]
        type_ = self._type(bool(values[0][1]))
        if type_ is not None:
            yield type_
        yield from self._access()
        yield from values
        yield from self._limits()
        yield self._denotation()
        key, flags, at = self._attribute("ObjFlags", "objFlags")
        yield key, f"0x{flags}" if flags and flags[:2].lower() != "0x" else flags, at
        yield from self._physical()

    def _attribute(self, key: str, attribute: str) -> _Entry:
        value = line(self._element.get("", attribute))
        return key, value, self._element.place(attribute)

    def _name(self) -> _Entry:
        key, value, at = self._attribute("ParameterName", "name")
        for each in self._chain:
            value = value or self._find.text(each)
        return key, value, at

    def _value(self, key: str, name: str) -> _Entry:
        for each in self._chain:
            child = self._find.first(each, name)
            if child is not None and child.get("", "value"):
                return key, line(child.get("", "value")), child.place("value")
        return self._attribute(key, name)

    def _type(self, is_valued: bool) -> _Entry | None:
        written = self._element.get("", "dataType").strip()
        at = self._element.place("dataType")
        code = written if written[:2].lower() == "0x" else f"0x{written}"
        referred, source = None, self._element
        for each in [*self._chain, *([self._member] if self._member else [])]:
            referred = self._parameters.type_of(each, is_valued)
            source = each
            if referred is not None:
                break
        if not written:
            text = None if referred is None else f"0x{int(referred):04X}"
            return None if text is None else ("DataType", text, source.span)
        number = parse(code)
        octets = (DataType.OCTET_STRING, DataType.DOMAIN)
        if (
            number is not None
            and referred is not None
            and number.value != referred
            and referred not in octets
        ):
            message = f"dataType is {written}, and the parameter has {referred.name}"
            self._parameters.findings.add(rules.TWO_TYPES, at, message)
        return "DataType", code if number is not None else written, at

    def _access(self) -> Iterator[_Entry]:
        mapping = self._element.get("", "PDOmapping").strip()
        word = self._element.get("", "accessType").strip()
        at = self._element.place("accessType")
        for each in reversed(self._chain):
            own = each.get("", "access", "" if word else "read")
            if own:
                known = ACCESS.get(own)
                word, at = known.value if known else own, each.place("access")
        if word == "rw":
            word = _ONE_WAY.get(mapping, word)
        is_composed = self._find.has(self._element, "CANopenSubObject")
        if not is_composed:
            yield "AccessType", word, at
        if mapping not in _NOT_MAPPABLE:
            yield "PDOMapping", "1", self._element.place("PDOmapping")

    def _limits(self) -> Iterator[_Entry]:
        for each in self._chain:
            allowed = self._find.first(each, "allowedValues")
            ranges = list(self._find.all(allowed, "range"))
            if not ranges:
                continue
            if len(ranges) > 1:
                message = f"of {len(ranges)} ranges, the limits of all are read"
                self._parameters.findings.add(rules.NOT_READ, ranges[1].span, message)
            for key, name, best in (
                ("LowLimit", "minValue", min),
                ("HighLimit", "maxValue", max),
            ):
                ends = [
                    e for r in ranges if (e := self._find.first(r, name)) is not None
                ]
                if len(ends) == len(ranges):
                    numbers = [
                        (_number(e.get("", "value")), n) for n, e in enumerate(ends)
                    ]
                    end = ends[best(numbers)[1]]
                    yield key, end.get("", "value").strip(), end.place("value")
            return
        yield self._attribute("LowLimit", "lowLimit")
        yield self._attribute("HighLimit", "highLimit")

    def _denotation(self) -> _Entry:
        for each in self._chain:
            child = self._find.first(each, "denotation")
            text = self._find.text(child) or self._find.text(child, "description")
            if child is not None and text:
                return "Denotation", text, child.span
        return self._attribute("Denotation", "denotation")

    def _physical(self) -> Iterator[_Entry]:
        """Yield unit, factor and description, which are of parameters only."""
        for each in self._chain:
            unit = self._find.first(each, "unit")
            if unit is not None:
                yield "Unit", self._find.text(unit), unit.span
            factor = each.get("", "multiplier").strip()
            if factor not in ("", "1", "1.0"):
                yield "Factor", factor, each.place("multiplier")
            offset = parse(each.get("", "offset").strip() or "0")
            if offset is None or offset.value:
                message = "the offset of a parameter is not read: values are raw"
                at = each.place("offset")
                self._parameters.findings.add(rules.NOT_READ, at, message)
            yield "Description", self._find.text(each, "description"), each.span


def _number(text: str) -> float:
    number = parse(text.strip())
    if number is not None:
        return number.value
    try:
        return float(text)
    except ValueError:
        return 0.0
