"""Calls and samples between processes over omniORB."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing
from pathlib import Path

import pytest
from msgspec.structs import replace
from patience import PATIENCE, until

pytest.importorskip("omniORB", reason="omniORBpy is not installed")

sys.path.insert(0, str(Path(__file__).parents[2] / "compiler" / "types"))

import emitted
from corba_runs import Here, Run, answers

from rtgen import runtime
from rtgen.compiler import model
from rtgen.compiler.diagnostics import ToolError
from rtgen.compiler.project import load
from rtgen.compiler.systems.reading import read_file
from rtgen.runtime.corba.naming import Naming
from rtgen.runtime.corba.orb import Orb
from rtgen.runtime.corba.transport import NamedCorba
from rtgen.runtime.services.ports import ServicePort
from rtgen.tools.running.assembly import assemble
from rtgen.tools.running.factories import Factories

pytestmark = pytest.mark.waits


def test_results_exceptions_and_attributes(
    here: Here, serving: Callable[[], Run]
) -> None:
    from calcbot.calc import Refused

    serving()
    here.connect()
    here.transport.await_others(PATIENCE)
    assert here.adder.add(2, 3) == 5
    with pytest.raises(Refused) as caught:
        here.adder.add(0, 13)
    assert caught.value == Refused("unlucky", 13)
    assert here.adder.naps == 0
    here.system.disconnect(here.system.connectors[0])
    with pytest.raises(runtime.ObjectNotExist, match="is not connected"):
        here.adder.add(2, 3)
    here.connect(port_connection_strictness="strict")
    assert here.adder.add(2, 3) == 5


def test_a_provider_that_is_named_by_a_property(
    here: Here, serving: Callable[[], Run]
) -> None:
    serving()
    wish = "Caller0.port.adding.required.Calc::Adder.Adder"
    addresses = ("Caller0", "adding"), ("Counter0", "adding")
    key = "Counter0.port.adding.provided.Calc::Adder.Adder"
    here.system.connect(*addresses, {wish: key})
    assert here.adder.add(2, 3) == 5
    here.system.disconnect(here.system.connectors[0])
    here.system.connect(*addresses, {wish: key[:-5] + "Other"})
    with pytest.raises(runtime.PortTypeError, match="it has: Adder"):
        here.transport.await_others(1.0)
    here.system.disconnect(here.system.connectors[0])
    for properties, message in (
        ({wish: "Counter0.port.other.provided.Calc::Adder.Adder"}, "is not a provider"),
        ({"Caller0.port.adding.required.X.Y": key}, "names no consumer"),
        ({"port.connection.x": "y"}, "unknown connector property"),
    ):
        with pytest.raises(runtime.ConnectorPropertyError, match=message):
            here.system.connect(*addresses, properties)


def test_definitions_that_differ(here: Here, tmp_path: Path) -> None:
    operations = "long add(in long a); void nap(in double seconds);"
    changed = f"module Calc {{ interface Adder {{ {operations} }}; }};"
    other = emitted.emit_text(tmp_path, changed).calc.Adder
    objects, naming = here.transport._objects, here.transport._naming
    assert naming is not None
    reference = objects.serve(other, lambda operation, arguments: None)
    place = ("Counter0", "adding"), "Adder"
    naming.bind(*place, reference)
    here.connect()
    message = (
        r"different definitions of Calc::Adder; the provider has no readonly attribute "
        r"unsigned long naps, long add\(in long a, in long b\) raises \(Calc::Refused\)$"
    )
    with pytest.raises(runtime.PortTypeError, match=message):
        here.transport.await_others(0.0)
    with pytest.raises(runtime.CommunicationFailure, match="different definitions"):
        here.adder.add(2, 3)
    naming.unbind(*place, reference)


def test_nobody_serves_a_port_that_is_connected_meanwhile(here: Here) -> None:
    here.connect()
    for message in ("nobody serves Counter0.adding", "not tried again so soon"):
        with pytest.raises(runtime.ObjectNotExist, match=message):
            here.adder.add(2, 3)


def test_who_is_missing_is_named(here: Here, serving: Callable[[], Run]) -> None:
    assert here.transport.missing == []
    here.connect()
    assert here.transport.missing == ["Counter0"]
    serving()
    until(lambda: not here.transport.missing)


def test_only_ports_that_are_there_reach_other_processes(here: Here) -> None:
    with pytest.raises(runtime.UnknownPortError):
        here.system.connect(("Caller0", "nothing"), ("Counter0", "adding"))
    with pytest.raises(runtime.UnknownComponentError):
        here.system.connect(("Other0", "adding"), ("Counter0", "adding"))
    here.connect()
    with pytest.raises(runtime.DuplicateConnectionError):
        here.system.connect(
            ("Caller0", "adding"), ("Counter0", "adding"), name="another"
        )


def test_samples_go_between_processes(here: Here, names: str, stack: ExitStack) -> None:
    from calc_nodes import Counter

    # For this transport, objects of another one are those of another process.
    transport = stack.enter_context(NamedCorba(name_server=names))
    system = stack.enter_context(runtime.System(runtime.RealClock(), transport))
    counter = Counter("Counter0")
    system.add(counter)
    for each in (here.system, system):
        each.connect(("Counter0", "done"), ("Caller0", "done"), name="data")
    transport.await_others(PATIENCE)
    here.transport.await_others(PATIENCE)
    done = counter.out_ports["done"]
    assert done.write(done.type()) is runtime.PORT_OK
    assert here.caller.in_ports["done"].read() == done.type()
    here.system.disconnect("data")
    assert done.connectors == ()
    assert done.write(done.type()) is runtime.PortStatus.PRECONDITION_NOT_MET


@pytest.fixture(params=["an ORB of its own", "a running ORB"])
def orb_before(request: pytest.FixtureRequest) -> Iterator[None]:
    """Create an ORB with another time-out, or none."""
    import omniORB

    if request.param != "a running ORB" or omniORB.orb is not None:
        yield
        return
    options = ["test", "-ORBclientCallTimeOutPeriod", "10000"]
    running = omniORB.CORBA.ORB_init(options, omniORB.CORBA.ORB_ID)
    yield
    running.destroy()


@pytest.mark.sampled(1)
@pytest.mark.usefixtures("orb_before")
def test_a_call_takes_no_longer_than_the_time_out_and_is_sent_once(
    project: Path, names: str, stack: ExitStack, serving: Callable[[], Run]
) -> None:
    serving()
    here = Here(stack, names, timeout=1.0)
    here.connect()
    assert here.adder.add(2, 3) == 5
    with pytest.raises(runtime.CallTimeout):
        here.adder.nap(2.0)
    until(lambda: answers(here) and here.adder.naps == 1)
    here.adder.nap(0.0)
    assert here.adder.naps == 2


@pytest.mark.slow
def test_a_process_ends_though_a_servant_does_not_return(
    project: Path, names: str, stack: ExitStack, serving: Callable[[], Run]
) -> None:
    counter = serving()
    here = Here(stack, names, timeout=0.3)
    here.connect()
    with pytest.raises(runtime.CallTimeout):
        here.adder.nap(3600.0)
    assert counter.end() == 0, counter.error_text()


def test_a_port_that_only_provides_waits_for_nobody(
    project: Path, names: str, stack: ExitStack
) -> None:
    from calc_nodes import Counter

    transport = stack.enter_context(NamedCorba(name_server=names))
    system = stack.enter_context(runtime.System(runtime.RealClock(), transport))
    counter = Counter("Counter0")
    system.add(counter)
    system.connect(("Counter0", "adding"), ("Caller0", "adding"))
    transport.await_others(0.0)
    assert bool(ServicePort(counter, "adding"))
    system.disconnect(system.connectors[0])


@pytest.fixture
def calling(project: Path) -> model.System:
    """Return the system with the component that only calls, unconnected."""
    system, diagnostics, _ = read_file(project / "calc.xml")
    assert system is not None, diagnostics
    caller = [each for each in system.components if each.instance == "Caller0"]
    return replace(system, components=tuple(caller), connections=())


def test_a_component_is_found_when_its_process_has_its_connections(
    calling: model.System, names: str
) -> None:
    found = []
    factories = Factories(load())
    with closing(Orb()) as orb, NamedCorba(name_server=names) as transport:
        naming = Naming(orb.orb, names)

        def look(_: runtime.System) -> None:
            found.append(naming.component("Caller0", "rtc"))

        clock = runtime.RealClock()
        with assemble(calling, factories, clock, [], [], transport, prepare=look) as it:
            look(it)
            it.remove("Caller0")
            look(it)
    assert [each is not None for each in found] == [False, True, False]


def test_a_component_that_another_process_has_is_refused(
    calling: model.System, names: str, here: Here
) -> None:
    with (
        NamedCorba(name_server=names) as transport,
        pytest.raises(ToolError, match=r"Caller0\.rtc is served by another process"),
    ):
        assemble(calling, Factories(load()), runtime.RealClock(), [], [], transport)
    with closing(Orb()) as orb:
        bound = Naming(orb.orb, names).component("Caller0", "rtc")
    assert here.transport.rt_objects is not None
    assert here.transport.rt_objects.own(bound) is not None
