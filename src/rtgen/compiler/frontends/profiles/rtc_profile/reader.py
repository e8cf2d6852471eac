"""Reads the elements of an RtcProfile as texts, without resolving types."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import isfinite
from pathlib import PureWindowsPath

from rtgen.compiler.diagnostics import Span
from rtgen.compiler.frontends.kit.findings import Findings
from rtgen.compiler.frontends.kit.located_xml import Element
from rtgen.compiler.frontends.profiles.rtc_profile.constraints import (
    NoTextFormError,
    constraint,
)
from rtgen.compiler.frontends.profiles.rtc_profile.names import (
    COMPONENT_TYPES,
    RTC,
    RTC_DOC,
    RTC_EXT,
    WIDGET,
)
from rtgen.compiler.model.rtc_profile import (
    EVENT_ARGUMENTS,
    ProfileDataPort,
    ProfileInterface,
    ProfileParameter,
    ProfileServicePort,
    RtcProfile,
)
from rtgen.compiler.typemap.profiles import rules
from rtgen.compiler.typemap.profiles.dates import has_zone, is_date
from rtgen.compiler.typemap.profiles.escapes import lines, one_line
from rtgen.compiler.typemap.profiles.facts import (
    ACTIVITY_PROPERTY,
    PROPERTY,
    TRIGGERS_PROPERTY,
    Facts,
    checked,
    facts_from,
)
from rtgen.facts.activities import ACTIVITIES, EVENT_DRIVEN
from rtgen.facts.constraints import Constraint

VERSIONS = ("0.1", "0.2", "0.3")

_EVENT_PORT = "EventPort"
_DEFAULT_DATE = "1970-01-01T00:00:00+00:00"


class Reader:
    """Reads one file; reports to `findings`."""

    def __init__(self, file: str, findings: Findings) -> None:
        self._findings = findings
        self._file = file
        self._misspellings: set[str] = set()

    def profile(self, root: Element) -> RtcProfile | None:
        """Return the profile; None if it is unusable."""
        if root.name != (RTC, "RtcProfile"):
            message = f"the root element is `{root.name[1]}`, not `RtcProfile` of {RTC}"
            self._findings.add(rules.NOT_A_PROFILE, root.span, message)
            return None
        self._word(root, "version", VERSIONS, "0.3")
        self._required_attribute(root, "id", "")
        info = root.first(RTC, "BasicInfo")
        if info is None:
            self._findings.add(rules.MISSING, root.span, "there is no `rtc:BasicInfo`")
            return None
        name = self._name(root, info)
        if name is None:
            return None
        description = self._get(info, "description")
        return RtcProfile(
            file=self._file,
            span=info.place("name"),
            name=name,
            vendor=self._required_attribute(info, "vendor", ""),
            category=self._required_attribute(info, "category", ""),
            version=self._required_attribute(info, "version", "1.0.0"),
            description=one_line(description),
            doc=lines(self._get(info, "abstract") or _doc(info) or description),
            component_type=self._word(info, "componentType", COMPONENT_TYPES, "STATIC"),
            activity=self._activity(info),
            kind=self._required_attribute(info, "componentKind", "DataFlowComponent"),
            execution=self._required_attribute(
                info, "executionType", "PeriodicExecutionContext"
            ),
            rate=self._rate(info),
            max_instances=self._max_instances(info),
            language=self._language(root),
            created=self._date(info, "creationDate"),
            updated=self._date(info, "updateDate"),
            parameters=tuple(self._parameters(root)),
            data_ports=tuple(self._data_ports(root)),
            service_ports=tuple(self._service_ports(root)),
            facts=self._facts(info),
            activity_type=dict(_properties(info)).get(ACTIVITY_PROPERTY, ""),
            triggers=dict(_properties(info)).get(TRIGGERS_PROPERTY, ""),
        )

    # Attributes.

    def _get(self, element: Element, name: str, *others: str) -> str:
        """Return the attribute `rtc:name` or a variant: without prefix, or misspelt."""
        value = element.attributes.get((RTC, name))
        if value is not None:
            return value
        for namespace, local in (("", name), *((RTC, o) for o in others)):
            value = element.attributes.get((namespace, local))
            if value is not None:
                written = local if not namespace else f"rtc:{local}"
                self._misspelt(element, local, written, f"rtc:{name}")
                return value
        return ""

    def _variable(self, element: Element) -> str:
        """Return `rtcExt:variableName`, which templates of format 0.1 call `varname`."""
        value = element.attributes.get((RTC_EXT, "variableName"))
        if value is not None:
            return value
        for namespace in (RTC_EXT, RTC):
            value = element.attributes.get((namespace, "varname"))
            if value is not None:
                self._misspelt(element, "varname", "varname", "rtcExt:variableName")
                return value
        return ""

    def _misspelt(self, element: Element, local: str, written: str, meant: str) -> None:
        """Report a misspelt name, once for each kind of element."""
        message = f"`{written}` of `{element.name[1]}` is read as `{meant}`"
        if message not in self._misspellings:
            self._misspellings.add(message)
            self._findings.add(rules.MISSPELT, element.place(local), message)

    def _name(self, root: Element, info: Element) -> str | None:
        """Return the component's name, by default that in the id."""
        name = self._get(info, "name").strip()
        if name:
            return name
        message = "`BasicInfo` has no `rtc:name`"
        parts = self._get(root, "id").split(":")
        if len(parts) == 5 and (name := parts[3].strip()):
            message += f"; {name}, of the id, is taken"
            self._findings.add(rules.LEFT_OUT, info.place("name"), message)
            return name
        self._findings.add(rules.MISSING, info.place("name"), message)
        return None

    def _required(self, element: Element, name: str) -> str | None:
        """Return an attribute without which the element is unusable."""
        value = self._get(element, name).strip()
        if value:
            return value
        message = f"a `{element.name[1]}` without `rtc:{name}` is left out"
        self._findings.add(rules.LOST, element.place(name), message)
        return None

    def _required_attribute(self, element: Element, name: str, usual: str) -> str:
        """Return an attribute that the schema requires; an empty one is accepted."""
        is_stated = (RTC, name) in element.attributes or (
            "",
            name,
        ) in element.attributes
        value = self._get(element, name).strip()
        if not is_stated:
            taken = f"; {usual} is taken" if usual else ""
            message = f"`{element.name[1]}` has no `rtc:{name}`{taken}"
            self._findings.add(rules.LEFT_OUT, element.span, message)
        return value or usual

    def _word(
        self, element: Element, name: str, words: Sequence[str], usual: str
    ) -> str:
        value = self._required_attribute(element, name, usual)
        if value in words:
            return value
        message = f"`rtc:{name}` is {value!r}; {usual} is taken"
        hint = f"it is one of {', '.join(words)}"
        self._findings.add(rules.UNKNOWN_WORD, element.place(name), message, hint=hint)
        return usual

    def _activity(self, info: Element) -> str:
        if self._get(info, "activityType") == "EVENT_DRIVEN":
            return EVENT_DRIVEN
        return self._word(info, "activityType", ACTIVITIES, "PERIODIC")

    def _rate(self, info: Element) -> float | None:
        text = self._get(info, "executionRate").strip()
        if not text:
            return None
        try:
            rate = float(text)
        except ValueError:
            rate = 0.0
        if isfinite(rate) and rate > 0:
            return rate
        message = f"the rate {text!r} is not a frequency above 0 Hz; 1000 is taken"
        self._findings.add(rules.BAD_NUMBER, info.place("executionRate"), message)
        return None

    def _language(self, root: Element) -> str:
        language = root.first(RTC, "Language")
        stated = "" if language is None else self._get(language, "kind").strip()
        return stated or "Python"

    def _max_instances(self, info: Element) -> int:
        text = self._get(info, "maxInstances").strip()
        try:
            count = int(text or "1")
        except ValueError:
            count = -1
        if 0 <= count < 1 << 31:
            return count
        message = f"`rtc:maxInstances` is {text[:40]!r}; 1 is taken"
        self._findings.add(rules.BAD_NUMBER, info.place("maxInstances"), message)
        return 1

    def _date(self, info: Element, name: str) -> str:
        text = self._required_attribute(info, name, _DEFAULT_DATE)
        if is_date(text):
            return text if has_zone(text) else f"{text}+00:00"
        message = f"`rtc:{name}` is {text[:40]!r}; {_DEFAULT_DATE} is taken"
        self._findings.add(rules.BAD_DATE, info.place(name), message)
        return _DEFAULT_DATE

    def _facts(self, element: Element) -> Facts:
        """Return additional facts written by rtgen; none in profiles of other tools."""
        value, place = self._property(element)
        return self._checked(value, place)

    def _property(self, element: Element) -> tuple[Facts, Span]:
        for item in element.all(RTC_EXT, "Properties"):
            if item.get(RTC_EXT, "name") != PROPERTY:
                continue
            place = item.place("value")
            try:
                return facts_from(item.get(RTC_EXT, "value")), place
            except ValueError as error:
                message = f"the property {PROPERTY} is ignored: {error}"
                self._findings.add(rules.FACTS, place, message)
        return {}, element.span

    def _checked(self, value: object, place: Span) -> Facts:
        facts, wrong = checked(value)
        for message in wrong:
            self._findings.add(
                rules.FACTS, place, f"the property {PROPERTY}: {message}"
            )
        return facts

    # Parameters and ports.

    def _parameters(self, root: Element) -> Iterator[ProfileParameter]:
        names: set[str] = set()
        for group in root.all(RTC, "ConfigurationSet"):
            for element in group.all(RTC, "Configuration"):
                name = self._required(element, "name")
                if name is None or not self._is_new(name, names, element, "parameter"):
                    continue
                properties = dict(_properties(element))
                yield ProfileParameter(
                    name=name,
                    type=self._required_attribute(element, "type", "string"),
                    default=self._required_attribute(element, "defaultValue", ""),
                    span=element.place("name"),
                    type_span=element.place("type"),
                    default_span=element.place("defaultValue"),
                    variable=self._variable(element),
                    unit=self._get(element, "unit"),
                    doc=lines(_doc(element)),
                    widget=properties.get(WIDGET, ""),
                    constraint=self._constraint(element),
                    facts=self._facts(element),
                )

    def _constraint(self, element: Element) -> Constraint | None:
        child = element.first(RTC, "Constraint")
        if child is None:
            return None
        try:
            return constraint(child)
        except NoTextFormError as error:
            message = f"the constraint is left out: {error}"
            self._findings.add(rules.CONSTRAINT, child.span, message)
            return None

    def _data_ports(self, root: Element) -> Iterator[ProfileDataPort]:
        names: dict[bool, set[str]] = {False: set(), True: set()}
        kinds = {"DataInPort": False, "DataOutPort": True, _EVENT_PORT: False}
        for element in root.all(RTC, "DataPorts"):
            name, kind = (self._required(element, n) for n in ("name", "portType"))
            if name is None or kind is None:
                continue
            output = kinds.get(kind)
            if output is None:
                message = f"a port of kind {kind!r} is left out"
                hint = ", ".join(kinds)
                self._findings.add(
                    rules.LOST, element.place("portType"), message, hint=hint
                )
                continue
            if not self._is_new(name, names[output], element, "port"):
                continue
            self._get(element, "subscriptionType", "subscriprionType")
            yield ProfileDataPort(
                name=name,
                output=output,
                type=self._required_attribute(element, "type", ""),
                span=element.place("name"),
                type_span=element.place("type"),
                idl_file=_base_name(self._get(element, "idlFile")),
                variable=self._variable(element),
                unit=self._get(element, "unit"),
                doc=lines(_doc(element)),
                facts=self._facts(element),
                for_events=kind == _EVENT_PORT,
                events=tuple(self._events(element)),
            )

    def _events(self, port: Element) -> Iterator[tuple[tuple[str, str], ...]]:
        for element in port.all(RTC, "Event"):
            if self._required(element, "name") is not None:
                yield tuple((key, self._get(element, key)) for key in EVENT_ARGUMENTS)

    def _service_ports(self, root: Element) -> Iterator[ProfileServicePort]:
        names: set[str] = set()
        for element in root.all(RTC, "ServicePorts"):
            name = self._required(element, "name")
            if name is None or not self._is_new(name, names, element, "service port"):
                continue
            interfaces = tuple(self._interfaces(element))
            if not interfaces:
                message = f"the service port {name!r} has no interface; it is left out"
                self._findings.add(rules.LOST, element.place("name"), message)
                continue
            yield ProfileServicePort(
                name=name,
                interfaces=interfaces,
                doc=lines(_doc(element)),
            )

    def _interfaces(self, port: Element) -> Iterator[ProfileInterface]:
        names: set[str] = set()
        facts, place = self._property(port)
        directions = {"provided": True, "required": False}
        for element in port.all(RTC, "ServiceInterface"):
            name, direction = (
                self._required(element, n) for n in ("name", "direction")
            )
            if name is None or direction is None:
                continue
            provided = directions.get(direction.lower())
            if provided is None:
                message = f"an interface of direction {direction!r} is left out"
                place = element.place("direction")
                self._findings.add(
                    rules.LOST, place, message, hint="Provided or Required"
                )
                continue
            if not self._is_new(f"{direction} {name}", names, element, "interface"):
                continue
            variable = self._variable(element)
            yield ProfileInterface(
                name=name,
                provided=provided,
                type=self._required_attribute(element, "type", ""),
                span=element.place("name"),
                type_span=element.place("type"),
                idl_file=_base_name(self._get(element, "idlFile")),
                variable=variable,
                instance=self._get(element, "instanceName"),
                doc=lines(_doc(element)),
                facts=self._checked(facts.get(variable, {}), place),
            )

    def _is_new(self, name: str, names: set[str], element: Element, what: str) -> bool:
        if name not in names:
            names.add(name)
            return True
        message = f"there is another {what} {name!r}; this one is left out"
        self._findings.add(rules.TWICE, element.place("name"), message)
        return False


def _properties(element: Element) -> tuple[tuple[str, str], ...]:
    return tuple(
        (name, item.get(RTC_EXT, "value"))
        for item in element.all(RTC_EXT, "Properties")
        if (name := item.get(RTC_EXT, "name"))
    )


def _doc(element: Element) -> str:
    doc = element.first(RTC_DOC, "Doc")
    return "" if doc is None else doc.get(RTC_DOC, "description")


def _base_name(path: str) -> str:
    return PureWindowsPath(path.strip()).name
