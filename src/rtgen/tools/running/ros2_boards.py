"""Boards of a project in a run with `--ros2`: their RTCs, functions of TECS as services."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

import msgspec
from msgspec.structs import replace

from rtgen import runtime
from rtgen.compiler import compilation
from rtgen.compiler.backends.tecs.function_text import function_names
from rtgen.compiler.diagnostics import Diagnostic, InputError, has_errors
from rtgen.compiler.layouts.tdr_messages import is_error_code
from rtgen.compiler.lowering.tecs.plan import RtcJoin
from rtgen.compiler.lowering.tecs.rtc_components import MARSHALLER, consumer_name
from rtgen.compiler.model import (
    Activation,
    Connection,
    PortReference,
    System,
    SystemComponent,
)
from rtgen.compiler.project import Project
from rtgen.compiler.typemap.tecs.python import struct_class
from rtgen.facts import opaque_rpc as facts
from rtgen.facts.cdl_files import CDL_SUFFIXES
from rtgen.facts.device_files import DEVICE_SUFFIXES
from rtgen.ros2.boards.interfaces import (
    MESSAGE,
    RETURNED,
    SUCCESS,
    BoardService,
    Interfaces,
    interfaces,
)
from rtgen.ros2.boards.values import Classes, to_board, to_message
from rtgen.ros2.devices import RosDevice, devices
from rtgen.runtime.opaque_rpc import (
    E_OBJ,
    E_PAR,
    E_RPC,
    ERCD,
    ArgumentError,
    RpcError,
)
from rtgen.runtime.opaque_rpc.errors import described
from rtgen.runtime.ros2.types import blank
from rtgen.runtime.services.servants import ServiceError
from rtgen.tools.recording.schema_types import message_classes
from rtgen.tools.running import ros2_devices

if TYPE_CHECKING:
    from rtgen.runtime.services.ports import Provider

_SUFFIXES = (*CDL_SUFFIXES, *DEVICE_SUFFIXES, ".toml")


class Served(msgspec.Struct, frozen=True):
    """A function of a board as a service: the joint's port, and what answers a request."""

    service: BoardService
    request: type[Any]
    response: type[Any]
    instance: str
    answer: Callable[[Any], Any]


class Boards:
    """The boards of a project with the services of their functions, and its CANopen devices."""

    def __init__(
        self, boards: Iterable[Interfaces], devices: Iterable[RosDevice], package: str
    ) -> None:
        self._interfaces = tuple(boards)
        self.devices = tuple(devices)
        self._package = package
        self._marshallers: dict[int, str] = {}
        """The instances of marshallers, by the joins' ids."""

    @property
    def findings(self) -> list[Diagnostic]:
        """The functions that are no services."""
        return [finding for each in self._interfaces for finding in each.findings]

    @property
    def _joins(self) -> Iterator[RtcJoin]:
        for each in self._interfaces:
            yield from each.board.plan.joins

    def completed(self, system: System, *, alone: bool) -> System:
        """Return a system with the marshaller and the communication RTC of each board.

        Those that the system has are used. `alone`: there is no system; managers and proxies of all
        CANopen buses are added, too.
        """
        if alone:
            system = ros2_devices.with_buses(system, self.devices)
        for join in self._joins:
            instance = _marshaller(system, join, self._joins)
            if instance is None:
                system, instance = _with_board(system, join)
            self._marshallers[id(join)] = instance
        return system

    def services(self, running: runtime.System) -> Iterator[Served]:
        """Yield the services of boards whose marshallers are in this process."""
        for each in self._interfaces:
            messages = message_classes(each.model)
            structs = self._structs(each, messages)
            names = {
                id(service): function_names(layout)
                for service, layout in zip(
                    each.board.plan.services, each.board.layouts, strict=True
                )
            }
            for service in each.services:
                instance = self._marshallers[id(service.join)]
                if instance not in running.instances:
                    continue
                method = names[id(service.join.service)][service.layout.function.name]
                request, response = (
                    messages[f"{service.interface}_{end}"]
                    for end in ("Request", "Response")
                )
                component = running.component(instance)
                port = component.providers[
                    service.join.service.module, service.join.service.module
                ]
                answer = answering(service, port, method, structs, response)
                yield Served(service, request, response, instance, answer)

    def _structs(
        self, services: Interfaces, messages: Mapping[str, type[Any]]
    ) -> Classes:
        """Return the classes of structs in CDL, and those of their messages."""
        records = {
            r.struct.name for each in services.board.layouts for r in each.records
        }
        if not records:
            return {}
        name = f"{self._package}.{services.board.plan.name}._types"
        types = import_module(name)
        return {
            tag: (getattr(types, struct_class(tag)), messages[message])
            for tag in records
            if (message := services.messages.get(tag)) is not None
        }


def of_project(project: Project) -> Boards | None:
    """Return the boards of a project; None if ROS 2 shows none. Raises InputError."""
    files = [path for path in project.sources if path.suffix.lower() in _SUFFIXES]
    if not (project.ros2.boards and files):
        return None
    boards = replace(project, sources=tuple(files), adapters=())
    read = compilation.read(boards, lowered=True)
    if has_errors(read.diagnostics):
        raise InputError([d for d in read.diagnostics if has_errors([d])])
    of_boards = interfaces(read.model, project.package)
    nodes = devices(read.model) if read.model.buses else []
    return Boards(of_boards, nodes, project.package) if of_boards or nodes else None


def _marshaller(system: System, join: RtcJoin, joins: Iterable[RtcJoin]) -> str | None:
    """Return the instance that carries calls of a join: connected to its communication RTC.

    The only one of its type does, if the signature is joined once.
    """
    type_ = f"{join.service.name}{MARSHALLER}"
    own = {c.instance for c in system.components if c.type == type_}
    for connection in system.connections:
        ends = {connection.source.instance, connection.target.instance}
        if join.instance in ends and ends & own:
            return next(iter(ends & own))
    once = [each.service is join.service for each in joins].count(True) == 1
    return next(iter(own)) if len(own) == 1 and once else None


def _with_board(system: System, join: RtcJoin) -> tuple[System, str]:
    """Return a system with the RTCs of a board, and the instance of its marshaller."""
    taken = {component.instance for component in system.components}
    span = join.through.span
    type_ = f"{join.service.name}{MARSHALLER}"
    marshaller = _free(type_, taken)
    added = [
        SystemComponent(instance=marshaller, type=type_, id="", path_uri="", span=span)
    ]
    communication = join.instance
    if communication not in taken:
        conf = Path(system.file).absolute().parent / f"{communication}.conf"
        added.insert(
            0,
            SystemComponent(
                instance=communication,
                type=facts.COMPONENT,
                id="",
                path_uri="",
                span=span,
                configuration=() if conf.is_file() else (("default", _settings(join)),),
            ),
        )
    source = PortReference(instance=marshaller, port=consumer_name(join.service))
    target = PortReference(instance=communication, port=facts.PORT)
    connection = Connection(
        name=f"{marshaller}.{source.port}_{communication}.{target.port}",
        source=source,
        target=target,
        service=True,
        span=span,
    )
    activation = tuple(
        Activation(instance=each.instance, sequence=0)
        for each in added
        if system.activation
    )
    whole = replace(
        system,
        components=(*system.components, *added),
        connections=(*system.connections, connection),
        activation=(*system.activation, *activation),
    )
    return whole, marshaller


def _free(type_: str, taken: Collection[str]) -> str:
    return next(
        f"{type_}{n}" for n in range(len(taken) + 1) if f"{type_}{n}" not in taken
    )


def _settings(join: RtcJoin) -> tuple[tuple[str, str], ...]:
    """Return the parameters of a join's communication RTC, as its `.conf` file has them."""
    options = join.options
    if options.device:
        own = [("type", "SERIA"), ("port", options.device)]
        own.append(("baudrate", str(options.baudrate)))
    else:
        own = [("ipaddr", options.address), ("port", str(join.port))]
    return (*own, ("timeout", str(options.timeout)))


def answering(
    service: BoardService,
    port: Provider[Any],
    method: str,
    structs: Classes,
    response: type[Any],
) -> Callable[[Any], Any]:
    """Return what answers a request: the function is called, and its failure is a response."""
    layout = service.layout
    fields = {item.name: field for item, field in service.arguments}
    given = [
        None if item.asked else (fields[item.name], to_board(item, structs))
        for item in layout.arguments
    ]
    returns_code = is_error_code(layout.function.returns)
    converts = [(field, to_message(item, structs)) for item, field in service.results]

    def answer(request: Any) -> Any:
        values: dict[str, Any] = {}
        try:
            arguments = [
                True if each is None else each[1](getattr(request, each[0]))
                for each in given
            ]
            messages, channel = _reached(port, method)
            results = messages.results_of(channel, *arguments)
            pairs = zip(converts, results, strict=False)
            values = {field: convert(value) for (field, convert), value in pairs}
            reason = ""
            if returns_code and values[RETURNED] < 0:
                reason = described(values[RETURNED])
        except (ArgumentError, ServiceError) as error:
            reason = str(error)
            if returns_code:
                values = {RETURNED: _code(error)}
        message = blank(response._descriptor_)
        for field, value in (
            *((SUCCESS, not reason), (MESSAGE, reason)),
            *values.items(),
        ):
            setattr(message, field, value)
        return message

    return answer


def _code(error: ArgumentError | ServiceError) -> int:
    """Return the error code of a call that could not be made."""
    if isinstance(error, RpcError):
        return error.code
    return ERCD(E_RPC, E_PAR if isinstance(error, ArgumentError) else E_OBJ)


def _reached(port: Provider[Any], method: str) -> tuple[Any, Any]:
    """Return a function's messages and the channel of its board. Raises ServiceError."""
    if not port.exists:
        raise ServiceError(f"{port.owner} is not ACTIVE")
    servant: Any = port.servant
    proxy = servant._proxy  # operations of an interface may have any other name
    return proxy.codec.functions[method], proxy.channel
