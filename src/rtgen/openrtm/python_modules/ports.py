"""Extracts the ports of a component from the calls that create and add them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Protocol

from rtgen.compiler.diagnostics import Rule, Span
from rtgen.compiler.model.rtc_profile import (
    EVENT_ARGUMENTS,
    ProfileDataPort,
    ProfileInterface,
    ProfileServicePort,
)
from rtgen.openrtm.python_modules import rules
from rtgen.openrtm.python_modules.expressions import is_made
from rtgen.openrtm.python_modules.values import (
    Component,
    Made,
    Module,
    Value,
    alternatives,
    scoped,
)
from rtgen.openrtm.python_modules.walker import Call, Walker

ADD_DATA_PORT = ("addInPort", "addOutPort", "registerInPort", "registerOutPort")
ADD_SERVICE_PORT = ("addPort", "registerPort")

_WAITING = ("CSPInPort", "CSPOutPort")
_EVENTS = ("EventInPort", "CSPEventPort")
_OUTPUTS = ("OutPort", "CSPOutPort")
_DATA_PORTS = ("InPort", "OutPort", *_WAITING, *_EVENTS)
_BIND = "bindEvent"
_UNKNOWN_TYPE = "Unknown"


class ReportAt(Protocol):
    """Function that reports a diagnostic."""

    def __call__(
        self, rule: Rule, span: Span, message: str, hint: str | None = None
    ) -> None: ...


class Ports:
    """Ports of a component whose constructor and onInitialize have been evaluated."""

    def __init__(
        self, walker: Walker, module: Module, component: Component, report_at: ReportAt
    ) -> None:
        self._walker = walker
        self._open_modules = module.open_modules
        self._component = component
        self._report_at = report_at

    def _span(self, instance: Made) -> Span:
        node = instance.node
        end = node.end_lineno or node.lineno
        column = (node.end_col_offset or node.col_offset) + 1
        return Span(instance.file, node.lineno, node.col_offset + 1, end, column)

    def _holder(self, instance: Made) -> str:
        """Return the attribute that holds a port, with a leading blank; empty without one."""
        for name, value in self._component.attributes.items():
            if value is instance:
                return f" {name}"
        return ""

    # Data ports.

    def data_ports(self) -> Iterator[ProfileDataPort]:
        """Yield the data ports in order of creation."""
        adding = [call for call in self._walker.calls if call.name in ADD_DATA_PORT]
        added: dict[Made, bool] = {}
        for call in adding:
            choices = [*alternatives(call.argument(1, "inport", "outport"))]
            ports = [each for each in choices if is_made(each, *_DATA_PORTS)]
            for port in ports:
                certain = call.made.certain and len(choices) == 1
                added[port] = added.get(port, False) or certain
            if len(ports) < max(len(choices), 1):
                name = call.argument(0, "name")
                shown = name if isinstance(name, str) else ""
                message = f"the port {shown} is computed"
                self._report_at(rules.COMPUTED, self._span(call.made), message)
        created = [each for each in self._walker.made if is_made(each, *_DATA_PORTS)]
        by_name: dict[tuple[bool, str], list[ProfileDataPort]] = {}
        for each in created:
            port = self._data_port(each, added)
            if port is not None:
                by_name.setdefault((port.output, port.name), []).append(port)
        for same in by_name.values():
            types = list(dict.fromkeys(port.type for port in same))
            if len(types) > 1:
                self._chosen(same[0].span, same[0].name, types)
            yield same[0] if len(types) == 1 else _opaque(same[0])

    def _data_port(
        self, instance: Made, added: dict[Made, bool]
    ) -> ProfileDataPort | None:
        span = self._span(instance)
        name = instance.argument(0, "name")
        if not isinstance(name, str):
            message = f"the name of the port{self._holder(instance)} is computed"
            self._report_at(rules.COMPUTED, span, message)
            return None
        if instance not in added:
            self._report_at(rules.NOT_ADDED, span, f"the port {name} is left out")
            return None
        if not (added[instance] and instance.certain):
            message = f"the existence of the port {name} depends on the run"
            self._report_at(rules.COMPUTED, span, message)
        if is_made(instance, *_EVENTS):
            return self._event_port(instance, name, span)
        if is_made(instance, *_WAITING):
            message = (
                f"{name} is a CSP port, which waits for its peer; a plain one is made"
            )
            if not is_made(instance, *_OUTPUTS):
                message += ", with the type of its values instead of `any`"
            self._report_at(rules.NOT_CARRIED, span, message)
        return ProfileDataPort(
            name=name,
            output=is_made(instance, *_OUTPUTS),
            type=self._type(instance.argument(1, "value"), name, span),
            span=span,
            type_span=span,
        )

    def _type(self, value: Value, name: str, span: Span) -> str:
        candidates = [self._data_type(each) for each in alternatives(value)]
        types = [*dict.fromkeys(each for each in candidates if each is not None)]
        if len(types) == 1 and None not in candidates:
            return types[0]
        if len(types) > 1:
            self._chosen(span, name, types)
        else:
            message = f"the type of the port {name} is computed"
            self._report_at(rules.COMPUTED, span, message)
        return _UNKNOWN_TYPE

    def _chosen(self, span: Span, name: str, types: list[str]) -> None:
        message = f"the type of the port {name} is chosen when it runs"
        self._report_at(rules.COMPUTED, span, message, f"it may be {', '.join(types)}")

    def _data_type(self, datum: Value) -> str | None:
        if is_made(datum, "instantiateDataType"):
            return scoped(datum.argument(0), self._open_modules)
        if isinstance(datum, Made):
            return scoped(datum, self._open_modules)
        return None

    def _event_port(self, instance: Made, name: str, span: Span) -> ProfileDataPort:
        events = []
        types: dict[str, None] = {}
        for call in self._walker.calls:
            if call.holder is not instance or not call.name.startswith(_BIND):
                continue
            event = call.argument(0)
            if not isinstance(event, str):
                message = f"an event of the port {name} is computed"
                self._report_at(rules.COMPUTED, self._span(call.made), message)
                continue
            datum = call.argument(2)
            type_ = self._data_type(datum) or ""
            if call.name != f"{_BIND}0" and not type_:
                message = f"the type of the event {event} is computed"
                self._report_at(rules.COMPUTED, self._span(call.made), message)
            if type_:
                types[type_] = None
            values = {"name": event, "type": type_}
            events.append(
                tuple((key, values[key]) for key in EVENT_ARGUMENTS if values.get(key))
            )
        if len(types) > 1:
            self._chosen(span, name, list(types))
        elif not types:
            message = f"the port {name} accepts events of any type"
            self._report_at(rules.COMPUTED, span, message)
        else:
            message = f"the port {name} is registered with the type `any`; "
            message += f"the definition has that of its events, {next(iter(types))}"
            self._report_at(rules.NOT_CARRIED, span, message)
        return ProfileDataPort(
            name=name,
            output=False,
            type=next(iter(types)) if len(types) == 1 else _UNKNOWN_TYPE,
            span=span,
            type_span=span,
            for_events=True,
            events=tuple(events),
        )

    # Service ports.

    def service_ports(self) -> Iterator[ProfileServicePort]:
        """Yield the service ports with their interfaces, in order of creation."""
        added = {
            port
            for call in self._walker.calls
            if call.name in ADD_SERVICE_PORT
            for port in alternatives(call.argument(0, "port"))
            if isinstance(port, Made)
        }
        seen: set[str] = set()
        for instance in self._walker.made:
            if not is_made(instance, "CorbaPort"):
                continue
            span = self._span(instance)
            name = instance.argument(0, "name")
            if not isinstance(name, str):
                message = (
                    f"the name of the service port{self._holder(instance)} is computed"
                )
                self._report_at(rules.COMPUTED, span, message)
            elif instance not in added:
                self._report_at(rules.NOT_ADDED, span, f"the port {name} is left out")
            elif name not in seen:
                seen.add(name)
                if not instance.certain:
                    message = f"the existence of the port {name} depends on the run"
                    self._report_at(rules.COMPUTED, span, message)
                interfaces = tuple(self._interfaces(instance))
                yield ProfileServicePort(name=name, interfaces=interfaces)

    def _interfaces(self, port: Made) -> Iterator[ProfileInterface]:
        kinds = {"registerProvider": True, "registerConsumer": False}
        for call in self._walker.calls:
            if call.holder is not port or call.name not in kinds:
                continue
            span = self._span(call.made)
            instance = call.argument(0, "instance_name")
            type_ = call.argument(1, "type_name")
            if not isinstance(instance, str) or not isinstance(type_, str):
                shown = self._holder(port).strip() or str(port.argument(0, "name"))
                message = f"an interface of the port {shown} is computed"
                self._report_at(rules.COMPUTED, span, message)
                continue
            provided = kinds[call.name]
            consumed = None if provided else self._consumed(call)
            # OpenRTM compares the registered name, which may omit the scope of the interface.
            facts = {"type_name": type_, "type": consumed} if consumed else {}
            yield ProfileInterface(
                name=instance,
                provided=provided,
                type=type_,
                span=span,
                type_span=span,
                facts=facts,
            )

    def _consumed(self, call: Call) -> str | None:
        """Return the interface of a `CorbaConsumer`, whose registered name may omit its module."""
        consumer = call.argument(2, "consumer")
        if not is_made(consumer, "CorbaConsumer"):
            return None
        return scoped(consumer.argument(0, "interfaceType"), self._open_modules)


def _opaque(port: ProfileDataPort) -> ProfileDataPort:
    return ProfileDataPort(
        name=port.name,
        output=port.output,
        type=_UNKNOWN_TYPE,
        span=port.span,
        type_span=port.type_span,
    )
