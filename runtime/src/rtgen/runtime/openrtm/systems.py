"""Starts and stops a system on OpenRTM-aist: find, connect, configure, activate, end components.

The client side of `connect.py`: names are resolved in one naming service, everything else is CORBA
calls by functions of OpenRTM_aist. All waits are bounded. Completed steps are kept, so that the
script can be run again.
"""

from __future__ import annotations

import argparse
import os
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from importlib import import_module
from math import isfinite
from pathlib import Path
from typing import Any

import msgspec

from rtgen.facts.files import open_file, read_start
from rtgen.runtime.openrtm.steps import StartError, Step, error_text

OK, FAILED = 0, 3
"""Exit codes."""

_STRICTNESS = "port.connection.strictness"
_ADDRESSES = ("corbaname:", "corbaloc:", "IOR:")
_POLL_INTERVAL = 0.05
_MAX_END = 65536
_CALL_TIMEOUT = 10_000
"""Time-out of calls in milliseconds, the unit of OpenRTM's managers."""


class Instance(msgspec.Struct, frozen=True, gc=False):
    """A component: `rate` in Hz, configuration sets, active set, wait before activation [s].

    `per_cycle` are parameters in units of one execution, with their values at `rate`: they grow
    when the rate is scaled down.
    """

    name: str
    rate: float | None = None
    configuration: Mapping[str, Mapping[str, str]] = msgspec.field(default_factory=dict)
    active_set: str = "default"
    per_cycle: Mapping[str, float] = msgspec.field(default_factory=dict)
    wait: float = 0.0
    foreign: str = ""
    """The `pathUri` of a component that other programs start and end; else empty."""


class Connection(msgspec.Struct, frozen=True, gc=False):
    """A connection of two ports `INSTANCE.PORT`, both data ports or both service ports.

    `id` is that of the system's connector, by which OpenRTM's tools remove it; it defaults to the
    name.
    """

    name: str
    source: str
    target: str
    properties: Mapping[str, str]
    id: str = ""


class System(msgspec.Struct, frozen=True, gc=False):
    """A system: `instances` in order of activation."""

    name: str
    instances: Sequence[Instance]
    connections: Sequence[Connection]


def main(system: System, arguments: Sequence[str] | None = None) -> int:
    """Run the command line; return the exit code."""
    options = _options(system, arguments)
    try:
        client = Client(options.nameserver, options.timeout, options.run)
        if options.stop:
            for line in client.stop(system):
                _print(line)
            return OK
        for line in client.start(system, options.rate_scale):
            _print(line)
    except StartError as error:
        print(f"{system.name}: {error}", file=sys.stderr)
        return FAILED
    return OK


def _options(system: System, arguments: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description=f"Connects, configures and activates the system {system.name}."
    )
    parser.add_argument(
        "--nameserver",
        metavar="HOST:PORT",
        default="127.0.0.1:2809",
        help="[%(default)s]",
    )
    parser.add_argument(
        "--rate-scale",
        type=_positive,
        default=1.0,
        metavar="X",
        help="run all components at X times their rates",
    )
    parser.add_argument(
        "--timeout",
        type=_positive,
        default=30.0,
        metavar="SECONDS",
        help="how long to wait for each step [%(default)s]",
    )
    parser.add_argument(
        "--run",
        type=Path,
        metavar="DIR",
        help="where start.sh has put ids and output of the processes",
    )
    parser.add_argument(
        "--stop", action="store_true", help="deactivate and end all components"
    )
    return parser.parse_args(arguments)


def _positive(text: str) -> float:
    number = float(text)
    if not (isfinite(number) and number > 0):
        raise argparse.ArgumentTypeError(f"{text} is not a number above 0")
    return number


def _print(line: str) -> None:
    print(line, flush=True)


class Client:
    """A CORBA client of the components of a system; `timeout` [s] limits each wait.

    `run` is a folder with `<Instance>.pid` and `<Instance>.out` of the components' processes: a
    component whose process has ended is not waited for.
    """

    def __init__(
        self, nameserver: str, timeout: float, run: Path | None = None
    ) -> None:
        self._nameserver = nameserver
        self._timeout = timeout
        self._run = run
        try:
            self._corba: Any = import_module("omniORB.CORBA")
            self._rtc: Any = import_module("RTC")
            self._openrtm: Any = import_module("OpenRTM_aist")
        except ImportError as error:
            raise StartError(f"OpenRTM-aist-Python is needed: {error}") from None
        argv = ["connect.py"]
        argv += ["-ORBclientCallTimeOutPeriod", str(_CALL_TIMEOUT)]
        argv += ["-ORBnativeCharCodeSet", "UTF-8"]
        self._orb = self._corba.ORB_init(argv, self._corba.ORB_ID)
        self._components: dict[str, Any] = {}

    def naming(self) -> Any:
        """Return the naming service. Raises StartError if it does not respond."""
        try:
            naming = self._openrtm.CorbaNaming(self._orb, self._nameserver)
            naming.getRootContext()._non_existent()
        except Exception as error:  # undocumented; also MemoryError
            message = f"no naming service at {self._nameserver}: {error_text(error)}"
            raise StartError(message) from None
        return naming

    def start(self, system: System, rate_scale: float = 1.0) -> Iterator[str]:
        """Start a system, and yield a message for each step. Raises StartError."""
        self._find(system)
        for connection in system.connections:
            for consumer in self._connect(connection):
                yield f"{connection.name}: {consumer} has no provider"
        yield f"{len(system.connections)} connections"
        for instance in system.instances:
            self._configure(instance, rate_scale)
        yield f"{len(system.instances)} components configured"
        for instance in system.instances:
            time.sleep(instance.wait)
            yield f"{instance.name} {self._activate(instance.name)}"
        self._require_active(system)
        # By now all writes to removed connectors have ended: see `_join`.
        for connection in system.connections:
            self._connect(connection)
        yield "ready"

    def stop(self, system: System) -> Iterator[str]:
        """Deactivate and end the remaining components, in reverse order."""
        naming = self.naming()
        for instance in reversed(system.instances):
            component = self._resolved(naming, instance)
            if component is None:
                continue
            try:
                if self._state(component) == self._rtc.ACTIVE_STATE:
                    self._openrtm.deactivate(component)
                if instance.foreign:
                    yield f"{instance.name} goes on: others have started it"
                    continue
                component.exit()
            except self._corba.SystemException as error:
                # a component that is ending may not respond any more
                yield f"{instance.name} does not answer: {error_text(error)}"
            else:
                yield f"{instance.name} ended"

    # Components

    def _find(self, system: System) -> None:
        naming = self.naming()
        missing = {instance.name: instance for instance in system.instances}

        def all_there() -> bool:
            for name in sorted(missing):
                component = self._resolved(naming, missing[name])
                if component is not None:
                    self._components[name] = component
                    del missing[name]
                else:
                    self._require_process(name)
            return not missing

        if not self._wait(all_there):
            names = ", ".join(
                f"{name} (foreign, at {each.foreign})" if each.foreign else name
                for name, each in sorted(missing.items())
            )
            raise StartError(f"not in the naming service {self._nameserver}: {names}")

    def _require_process(self, name: str) -> None:
        """Raise StartError if the process of a component has ended."""
        if self._run is None:
            return
        try:
            os.kill(int(read_start(self._run / f"{name}.pid", 32)), 0)
        except ProcessLookupError:
            last = self._last_line(name)
            raise StartError(f"the process of {name} has ended: {last}") from None
        except (OSError, ValueError):
            return  # not started by start.sh, or another user's

    def _last_line(self, name: str) -> str:
        """Return the last line printed by a component's process; empty if unknown."""
        if self._run is None:
            return ""
        try:
            with open_file(self._run / f"{name}.out") as stream:
                stream.seek(max(0, stream.seek(0, os.SEEK_END) - _MAX_END))
                text = stream.read(_MAX_END).decode("utf-8", "replace")
        except OSError:
            return ""
        return next(
            (each.strip() for each in reversed(text.split("\n")) if each.strip()), ""
        )

    def _resolved(self, naming: Any, instance: Instance) -> Any:
        """Return the running component of an instance, else None."""
        name = f"{instance.name}.rtc"
        if instance.foreign.startswith(_ADDRESSES):
            address = instance.foreign
            return self._living(lambda: self._orb.string_to_object(address))
        service, _, path = instance.foreign.partition("/")
        reference = self._living(lambda: naming.resolve(path)) if path else None
        reference = reference or self._living(lambda: naming.resolve(name))
        if reference is None and path:
            text = f"corbaname::{service}#{path}"
            reference = self._living(lambda: self._orb.string_to_object(text))
        return reference

    def _living(self, find: Callable[[], Any]) -> Any:
        """Return the result if it is a component whose process responds, else None."""
        try:
            reference = find()
            component = (
                None if reference is None else reference._narrow(self._rtc.RTObject)
            )
            alive = component is not None and not component._non_existent()
        except self._corba.Exception:  # not bound, or bound by a process that has ended
            return None
        return component if alive else None

    def _wait(self, done: Callable[[], bool]) -> bool:
        end = time.monotonic() + self._timeout
        while not done():
            if time.monotonic() > end:
                return False
            time.sleep(_POLL_INTERVAL)
        return True

    def _context(self, component: Any) -> Any:
        return component.get_owned_contexts()[0]

    def _state(self, component: Any) -> Any:
        return self._context(component).get_component_state(component)

    def _activate(self, name: str) -> str:
        component = self._components[name]
        inactive = self._rtc.INACTIVE_STATE
        with Step(f"{name} cannot be activated"):
            if self._state(component) == inactive:
                code = self._openrtm.activate(component)
                # RTC_ERROR: it takes longer than OpenRTM's half second. PRECONDITION_NOT_MET:
                # already in ERROR.
                if code == self._rtc.BAD_PARAMETER:
                    raise StartError(f"{code}")
            if not self._wait(lambda: self._state(component) != inactive):
                raise StartError(f"it is still inactive after {self._timeout:g} s")
            state = self._state(component)
            if state != self._rtc.ACTIVE_STATE:
                raise StartError(self._with_reason(f"it is in {state}", name))
        return str(state).removesuffix("_STATE")

    def _with_reason(self, text: str, name: str) -> str:
        """Return the text with the last line printed by the component's process."""
        return f"{text}: {self._last_line(name)}".removesuffix(": ")

    def _require_active(self, system: System) -> None:
        """Raise StartError if a component is in ERROR after two ticks of all components.

        In OpenRTM a component is ACTIVE before `onActivated`, until the tick after its failure.
        """
        with Step("a component does not answer"):
            contexts = map(self._context, self._components.values())
            rates = [context.get_rate() for context in contexts]
            ticks = [2.0 / rate for rate in rates if rate > 0]
            time.sleep(min(max(ticks, default=0.0), self._timeout))
            failed = [
                instance.name
                for instance in system.instances
                if self._state(self._components[instance.name]) == self._rtc.ERROR_STATE
            ]
        if failed:
            reasons = (self._with_reason(f"{n} is in ERROR_STATE", n) for n in failed)
            raise StartError("; ".join(reasons))

    # Configuration

    def _configure(self, instance: Instance, scale: float) -> None:
        component = self._components[instance.name]
        with Step(f"{instance.name} cannot be configured"):
            values = {s: dict(pairs) for s, pairs in instance.configuration.items()}
            for name, value in instance.per_cycle.items() if scale != 1.0 else ():
                values.setdefault(instance.active_set, {})[name] = repr(value / scale)
            sets = component.get_configuration()
            for set_id, pairs in values.items():
                self._set(sets, set_id, pairs)
            if values:
                sets.activate_configuration_set(instance.active_set)
            if scale != 1.0 and instance.rate is not None:
                code = self._context(component).set_rate(instance.rate * scale)
                if code != self._rtc.RTC_OK:
                    raise StartError(f"rate {instance.rate * scale:g} Hz: {code}")

    def _set(self, sets: Any, set_id: str, values: Mapping[str, str]) -> None:
        configuration_set = sets.get_configuration_set(set_id)
        names = {item.name for item in configuration_set.configuration_data}
        unknown = sorted(values.keys() - names)
        if unknown and set_id == "default":
            raise StartError(f"it has no parameter {', '.join(unknown)}")
        any_ = import_module("omniORB.any")
        pairs = import_module("SDOPackage").NameValue
        for item in configuration_set.configuration_data:
            if item.name in values:
                item.value = any_.to_any(values[item.name])
        configuration_set.configuration_data += [
            pairs(name, any_.to_any(values[name])) for name in unknown
        ]
        sets.set_configuration_set_values(configuration_set)

    # Connections

    def _connect(self, connection: Connection) -> list[str]:
        """Connect two ports; return the consumers that remain without a provider."""
        with Step(f"{connection.source} and {connection.target} cannot be joined"):
            ports = [self._port(end) for end in (connection.source, connection.target)]
            lonely = self._require_providers(connection, ports)
            if not self._joined(*ports):
                self._join(connection, ports)
            return lonely

    def _join(self, connection: Connection, ports: Sequence[Any]) -> None:
        """Make the connector of two ports. Raises StartError.

        It is made again if it is removed at once: an OutPort of OpenRTM that fails to write to a
        connector while it is removed, removes the connector with that id a little later.
        """
        properties = self._openrtm.Properties()
        for key, text in connection.properties.items():
            properties.setProperty(key, text)
        profile = self._openrtm.create_connector(connection.name, properties, *ports)
        profile.connector_id = connection.id or connection.name

        def made() -> bool:
            self._cut(profile.connector_id, ports)
            code, _ = ports[0].connect(profile)
            if code != self._rtc.RTC_OK:
                raise StartError(f"{code}")
            return self._joined(*ports)

        if not self._wait(made):
            raise StartError("there is no connector although the call was answered")

    def _require_providers(
        self, connection: Connection, ports: Sequence[Any]
    ) -> list[str]:
        """Return the consumers that the connection leaves without a provider.

        OpenRTM falls back to names if the provider that a property selects is missing, and returns
        RTC_OK for an unconnected consumer unless the connection is strict. Raises StartError for
        both, and for a property about an unknown consumer.
        """
        profiles = [port.get_port_profile() for port in ports]
        provided, required = (
            dict(pair for each in profiles for pair in self._interfaces(each, polarity))
            for polarity in (self._rtc.PROVIDED, self._rtc.REQUIRED)
        )
        offered = ", ".join(sorted(provided)) or "none"
        for key, provider in connection.properties.items():
            if ".required." not in key:
                continue
            if key not in required:
                names = ", ".join(sorted(required)) or "none"
                raise StartError(f"there is no consumer {key}; there are: {names}")
            if provider not in provided:
                raise StartError(
                    f"a consumer finds no provider {provider}; there are: {offered}"
                )
        lonely = [
            key
            for key, descriptor in required.items()
            if key not in connection.properties and descriptor not in provided.values()
        ]
        if lonely and connection.properties.get(_STRICTNESS) == "strict":
            raise StartError(
                f"a consumer finds no provider: {', '.join(lonely)}; there are: {offered}"
            )
        return lonely

    def _interfaces(self, profile: Any, polarity: Any) -> Iterator[tuple[str, str]]:
        """Yield key in connectors' properties, type and instance name of a port's interfaces."""
        instance = self._instance(profile.name)
        port = profile.name.removeprefix(f"{instance}.")
        word = "provided" if polarity == self._rtc.PROVIDED else "required"
        for each in profile.interfaces:
            if each.polarity == polarity:
                descriptor = f"{each.type_name}.{each.instance_name}"
                yield f"{instance}.port.{port}.{word}.{descriptor}", descriptor

    def _port(self, end: str) -> Any:
        instance = self._instance(end)
        ports = self._components[instance].get_ports()
        names = [port.get_port_profile().name for port in ports]
        own = end.removeprefix(f"{instance}.")
        # OpenRTM's name of a port is the part after the last dot.
        for candidate in (end, own, f"{instance}.{own.rpartition('.')[2]}"):
            if candidate in names:
                return ports[names.index(candidate)]
        raise StartError(f"{instance} has the ports {', '.join(names)}")

    def _instance(self, end: str) -> str:
        """Return the instance at the start of a port's name."""
        names = (name for name in self._components if end.startswith(f"{name}."))
        return max(names, key=len)

    def _cut(self, connector_id: str, ports: Sequence[Any]) -> None:
        """Remove the connector with an id, such as one with a component that was restarted."""
        for port in ports:
            ids = [each.connector_id for each in port.get_connector_profiles()]
            if connector_id in ids:
                port.disconnect(connector_id)

    def _joined(self, one: Any, other: Any) -> bool:
        return any(
            port._is_equivalent(other)
            for connector in one.get_connector_profiles()
            for port in connector.ports
        )
