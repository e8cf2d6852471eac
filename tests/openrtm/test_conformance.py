"""Every generated module in a manager of its own process, tested from outside over CORBA.

The behaviours are probes (`probes.py`): the tests cover ports, services, configuration and life
cycle, with values of every type of the ports.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import middleware
import openrtm_peers as peers
import pytest
from conformance import BEHAVIOURS, OTHERS, component_of, make_project
from openrtm_lab import Lab, resolved
from patience import until
from specimens import COUNT, specimen

from rtgen.facts.openrtm_ports import known_name
from rtgen.runtime import Component
from rtgen.runtime.rtc.profiles import ParameterProfile

HERE = Path(__file__).parent
IN_EVERY_RUN = {
    "Limiter",
    "RefHardRh3",
    "PositionInput",
    "EposDriveProxy",
    "MotorBoardMarshaller",
}
"""A quick selection; the rest is for each night."""


Ports = dict[str, tuple[Any, Any]]
"""rtgen's ports at each port of the module, and its type."""
Called = list[tuple[Any, Any]]
"""Interfaces, and consumers of them."""
Requests = dict[tuple[str, str], list[tuple[str, str]]]
"""The requests of the servant of a service port and instance."""


@pytest.fixture(scope="session")
def others(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Generate the project made for these tests; its output can be imported."""
    output = make_project(tmp_path_factory.mktemp("others"))
    sys.path += [str(output), str(output.parent / "src")]
    return output


@pytest.fixture
def output_of(request: pytest.FixtureRequest) -> Callable[[str], Path]:
    """Return a function for the output folder of a component's project."""

    def output(name: str) -> Path:
        project = "others" if name in OTHERS else "reference"
        found: Path = request.getfixturevalue(project)
        return found

    return output


@pytest.fixture(
    params=[
        pytest.param(name, marks=() if name in IN_EVERY_RUN else pytest.mark.nightly)
        for name in sorted([*BEHAVIOURS, *OTHERS])
    ]
)
def module(
    request: pytest.FixtureRequest,
    rtm: Any,
    lab: Lab,
    output_of: Callable[[str], Path],
    naming_service: str,
    rtm_environment: dict[str, str],
    tmp_path: Path,
) -> Iterator[Module]:
    """Yield a running module, its component and a view of its behaviour."""
    name: str = request.param
    output = output_of(name)
    folder = output / "openrtm" / name
    if not (folder / "stubs").is_dir():
        script = ["sh", "idlcompile.sh"]
        subprocess.run(script, cwd=folder, env=rtm_environment, check=True)
    peers.load_stubs(folder / "stubs")
    notes = tmp_path / "notes"
    notes.touch()
    path = [
        *map(str, (output, output.parent / "src", HERE)),
        rtm_environment.get("PYTHONPATH", ""),
    ]
    environment = {
        **rtm_environment,
        "PYTHONPATH": os.pathsep.join(path),
        "PROBED": {**BEHAVIOURS, **OTHERS}[name],
        "PROBE_NOTES": str(notes),
    }
    options = {
        "corba.nameservers": naming_service,
        "corba.endpoints": "127.0.0.1:",
        "logger.enable": "NO",
        # Differs from the name of an earlier process, whose binding may still exist.
        "naming.formats": f"{tmp_path.name}/%n.rtc",
        "exec_cxt.transition_timeout": "20",
    }
    command = [str(HERE / "probes.py"), str(folder / f"{name}.py")]
    with middleware.launched(command, options, environment, tmp_path) as process:
        bound = f"{tmp_path.name}/{name}0.rtc"
        component = resolved(rtm, naming_service, bound, process)
        yield Module(name, rtm, lab, component, notes, tmp_path)


@dataclass
class Module:
    """A component in its process, and the notes of its probe."""

    name: str
    rtm: Any
    lab: Lab
    component: Any
    notes: Path
    folder: Path

    @cached_property
    def behaviour(self) -> Component:
        """An equal component in this process, by the definition."""
        return component_of(self.name)

    def ports(self, kind: str, made: dict[Any, Any]) -> dict[Any, Any]:
        """Return ports of the behaviour that are in its definition: it may add others."""
        bases = type(self.behaviour).__mro__
        generated = (each for each in bases if each.__name__ == f"{self.name}Base")
        base = next(generated, bases[0])
        defined = base.profile.ports
        keys = {
            (p.port, p.instance) if p.port else p.name
            for p in defined
            if p.kind == kind
        }
        return {key: port for key, port in made.items() if key in keys}

    @cached_property
    def in_ports(self) -> dict[str, Any]:
        """Types of InPorts by name."""
        ports = self.ports("inport", self.behaviour.in_ports)
        return {name: port.type for name, port in ports.items()}

    @cached_property
    def out_ports(self) -> dict[str, Any]:
        """Types of OutPorts by name."""
        ports = self.ports("outport", self.behaviour.out_ports)
        return {name: port.type for name, port in ports.items()}

    @cached_property
    def providers(self) -> dict[tuple[str, str], Any]:
        """Provided interfaces by service port and instance."""
        ports = self.ports("provider", self.behaviour.providers)
        return {key: port.interface for key, port in ports.items()}

    @cached_property
    def consumers(self) -> dict[tuple[str, str], Any]:
        """Required interfaces by service port and instance."""
        ports = self.ports("consumer", self.behaviour.consumers)
        return {key: port.interface for key, port in ports.items()}

    def noted(self, event: str, **facts: Any) -> list[dict[str, Any]]:
        """Return the notes of an event."""
        # The part after the last line end is being written.
        whole = self.notes.read_text().split("\n")[:-1]
        lines = [json.loads(line) for line in whole]
        wanted = {"event": event, **facts}.items()
        return [line for line in lines if wanted <= line.items()]

    def port(self, name: str) -> Any:
        known = f"{self.name}0.{known_name(name)}"
        found = self.rtm.get_port_by_name(self.component, known)
        assert found is not None, name
        return found

    def out_name(self, name: str) -> str:
        """Return OpenRTM's name of an OutPort: it has no two ports of one name."""
        return f"{name}_out" if name in self.in_ports else name


@pytest.mark.sampled(1)
def test_a_module_conforms(module: Module) -> None:
    """Test profile, configuration, data, services, and life cycle of a module."""
    import RTC

    check_profile(module)
    check_interfaces(module)
    check_configuration(module)
    expected = set_parameters(module)
    data = connect_data(module)
    services = connect_services(module)
    assert module.rtm.activate(module.component) == RTC.RTC_OK
    until(lambda: module.noted("configuration"))
    assert module.noted("configuration")[0]["values"] == expected
    check_data(module, *data)
    check_services(module, *services)
    check_life_cycle(module)


def check_profile(module: Module) -> None:
    profile, defined = (
        module.component.get_component_profile(),
        module.behaviour.profile,
    )
    assert profile.instance_name == f"{module.name}0"
    for field in ("type_name", "description", "version", "vendor", "category"):
        assert getattr(profile, field) == getattr(defined, field), field
    rate = module.rtm.get_current_rate(module.component, 0)
    assert rate == defined.rate
    found = {
        (port.name, texts["port.port_type"], texts.get("dataport.data_type", ""))
        for port in profile.port_profiles
        for texts in (name_values(port.properties),)
    }
    prefix = f"{module.name}0."
    data = {
        (prefix + known_name(named(name)), kind, type_._descriptor_.repository_id)
        for kind, ports, named in (
            ("DataInPort", module.in_ports, str),
            ("DataOutPort", module.out_ports, module.out_name),
        )
        for name, type_ in ports.items()
    }
    services = {
        (prefix + known_name(port), "CorbaPort", "")
        for port, _ in (*module.providers, *module.consumers)
    }
    assert found == data | services


def check_interfaces(module: Module) -> None:
    import RTC

    found = {
        (
            profile.name,
            each.instance_name,
            each.type_name,
            each.polarity == RTC.PROVIDED,
        )
        for profile in module.component.get_component_profile().port_profiles
        for each in profile.interfaces
    }
    assert found == {
        (
            f"{module.name}0.{known_name(port)}",
            instance,
            interface._descriptor_.name,
            provided,
        )
        for provided, ports in (
            (True, module.providers),
            (False, module.consumers),
        )
        for (port, instance), interface in ports.items()
    }


def check_configuration(module: Module) -> None:
    sets = {
        each.id: name_values(each.configuration_data)
        for each in module.component.get_configuration().get_configuration_sets()
    }
    parameters = module.behaviour.profile.configuration
    assert sets.get("default", {}) == {p.name: p.default for p in parameters}
    for p in parameters:
        if p.widget:
            assert sets["__widget__"][p.name] == p.widget
        if p.constraint:
            assert sets["__constraints__"][p.name] == p.constraint
        elif p.minimum is not None or p.maximum is not None:
            assert sets["__constraints__"][p.name]
        assert sets["__type__"][p.name]


def name_values(properties: list[Any]) -> dict[str, str]:
    """Return a list of names and texts as a dictionary."""
    return {each.name: each.value.value() for each in properties}


def connect_data(module: Module) -> tuple[Ports, Ports]:
    """Return an OutPort at each of the module's InPorts, and an InPort at each of its OutPorts."""
    import RTC

    writers: Ports = {}
    readers: Ports = {}
    lab = module.lab
    for made, make, ports, named in (
        (writers, lab.out_port, module.in_ports, str),
        (readers, lab.in_port, module.out_ports, module.out_name),
    ):
        for name, type_ in ports.items():
            mine = make(peers.wire(specimen(type_._descriptor_, 0)))
            made[name] = mine, type_
            ends = [mine.getPortRef(), module.port(named(name))]
            asked = module.rtm.Properties()
            assert module.rtm.connect("data", asked, *ends) == RTC.RTC_OK, name
    return writers, readers


def check_data(module: Module, writers: Ports, readers: Ports) -> None:
    """Check that values of every type arrive unchanged on both sides."""
    for name, (writer, kind) in writers.items():
        sent = [specimen(kind._descriptor_, number) for number in range(COUNT)]
        for value in sent:
            assert writer.write(peers.wire(value)), name
        until(lambda n=name: len(module.noted("sample", port=n)) >= COUNT)
        came = [line["octets"] for line in module.noted("sample", port=name)]
        assert came == [value.to_cdr().hex() for value in sent], name
    for name, (reader, kind) in readers.items():
        for number in range(COUNT):
            until(reader.isNew)
            value = kind.from_cdr(peers.octets(reader.read()))
            assert value == specimen(kind._descriptor_, number), name


def connect_services(module: Module) -> tuple[Called, Requests]:
    """Connect consumers with the inactive module's providers; servants with its consumers."""
    import RTC
    from omniORB import CORBA

    called: Called = []
    requests: Requests = {}
    for name in {port for port, _ in (*module.providers, *module.consumers)}:
        outlet = module.rtm.CorbaPort(name)
        for (port, instance), interface in module.providers.items():
            if port == name:
                wanted = peers.interface_of(interface)
                consumer = module.rtm.CorbaConsumer(interfaceType=wanted)
                kind = interface._descriptor_.name
                outlet.registerConsumer(instance, kind, consumer)
                called.append((interface, consumer))
        for (port, instance), interface in module.consumers.items():
            if port == name:
                servant, requests[port, instance] = peers.servant(interface)
                outlet.registerProvider(instance, interface._descriptor_.name, servant)
        mine = module.lab.component()
        mine.addPort(outlet)
        module.lab.activate(mine)
        asked = module.rtm.Properties()
        asked.setProperty("port.connection.strictness", "strict")
        mine = outlet.getPortRef()
        assert module.rtm.connect("calls", asked, module.port(name), mine) == RTC.RTC_OK
    for interface, consumer in called:
        with pytest.raises(CORBA.OBJECT_NOT_EXIST):
            peers.call_all(interface, consumer._ptr(True))
    return called, requests


def check_services(module: Module, called: Called, requests: Requests) -> None:
    """Check arguments, results and exceptions both ways."""
    for interface, consumer in called:
        peers.call_all(interface, consumer._ptr(True))
    for (port, instance), interface in module.providers.items():
        name, count = f"{port}.{instance}", peers.number_of_calls(interface)
        # A oneway call may arrive later.
        until(lambda n=name, c=count: len(module.noted("served", port=n)) >= c)
        served = module.noted("served", port=name)
        peers.check_requests(interface, [(s["operation"], s["octets"]) for s in served])
    for (port, instance), interface in module.consumers.items():
        name, count = f"{port}.{instance}", peers.number_of_calls(interface)
        taken = requests[port, instance]
        until(lambda n=name, c=count: len(module.noted("called", port=n)) >= c)
        until(lambda t=taken, c=count: len(t) >= c)
        peers.check_requests(interface, taken)
        ended = module.noted("called", port=name)
        found = [(line["operation"], tuple(line["found"])) for line in ended]
        peers.check_outcomes(interface, found)


def changed(parameter: ParameterProfile) -> str:
    """Return another text for a parameter, within its limits."""
    if parameter.constraint.startswith("("):
        return parameter.constraint.strip("()").split(",")[-1].strip()
    match parameter.type:
        case "string":
            return "別の text"
        case "Lab::Mode":
            return "CLIP"
        case "sequence<double>":
            return "0.25, -4.0"
        case "boolean":
            return "false" if parameter.default.lower() in ("true", "1") else "true"
        case "double" | "float":
            return repr(float(parameter.default) / 2 + 0.25)
    return str(int(parameter.default) // 2 + 1)


def set_parameters(module: Module) -> str:
    """Set all parameters; return the values that an embedded behaviour has of the same texts."""
    parameters = module.behaviour.profile.configuration
    for parameter in parameters:
        text = changed(parameter)
        module.behaviour.configuration_sets.set(parameter.name, text)
        module.rtm.set_configuration(module.component, "default", parameter.name, text)
    module.behaviour.configuration_sets.apply()
    return repr(getattr(module.behaviour, "config", None))


def check_life_cycle(module: Module) -> None:
    """Check an error, a reset, another run; in OMG's order of callbacks, not OpenRTM's."""
    import RTC

    (module.folder / "fail").touch()
    until(lambda: module.rtm.is_in_error(module.component))
    until(lambda: module.noted("on_error"))
    assert module.rtm.reset(module.component) == RTC.RTC_OK
    assert module.rtm.is_in_inactive(module.component)
    assert module.rtm.activate(module.component) == RTC.RTC_OK
    assert module.rtm.deactivate(module.component) == RTC.RTC_OK
    lines = [
        json.loads(line)["event"] for line in module.notes.read_text().splitlines()
    ]
    order = [
        name
        for name, before in zip(lines, ["", *lines], strict=False)
        if name.startswith("on_") and name != before
    ]
    assert order == [
        *("on_initialize", "on_startup"),
        *("on_activated", "on_execute", "on_aborting", "on_error", "on_reset"),
        *("on_activated", "on_execute", "on_deactivated"),
    ]


def test_every_component_has_a_module(reference: Path) -> None:
    """The other tests cover all components."""
    found = {file.stem for file in reference.glob("openrtm/*/*.py")} - {"connect"}
    assert found == set(BEHAVIOURS)


@pytest.mark.skipif(not middleware.REAL, reason="OpenRTM-aist-Python is not installed")
def test_rtgen_conformance_has_nothing_to_complain_of(
    module: Module, naming_service: str, output_of: Callable[[str], Path]
) -> None:
    """rtgen's command checks OpenRTM's variant of a module, until and including its exit."""
    profile = output_of(module.name) / "openrtm" / module.name / "RTC.xml"
    command = [sys.executable, "-m", "rtgen", "conformance", str(profile), "--json"]
    command += [
        "--connect",
        f"{naming_service}/{module.folder.name}/{module.name}0.rtc",
    ]
    command += ["--actuate", "--defaults", "--exit", "--timeout", "20"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.stdout, done.stderr
    report = json.loads(done.stdout)
    problems = {o["check"]: o["problems"] for o in report["outcomes"]}
    failed = {o["check"] for o in report["outcomes"] if o["verdict"] == "failed"}
    assert not failed, {name: problems[name] for name in failed}
    assert report["outcomes"][-1]["check"] == "exit"
    assert report["outcomes"][-1]["verdict"] == "passed"
