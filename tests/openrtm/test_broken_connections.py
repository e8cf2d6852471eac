"""Connections to components in C++ that rtgen has not ended: named, counted, made again."""

from __future__ import annotations

import re
import signal
from collections.abc import Iterator

import cpp_build
import devices
import pytest
from devices import Processes
from logged_process import LoggedProcess
from patience import until
from watching_page import Page

from rtgen.runtime.corba.naming import Naming
from rtgen.runtime.corba.orb import Orb
from rtgen.runtime.corba.rt_objects.objects import Exported
from rtgen.runtime.corba.rt_objects.remote import RemoteRtc

pytestmark = [*cpp_build.needed, pytest.mark.waits]

LIMIT = ("-ORBgiopMaxMsgSize", "8192")
"""The least limit that omniORB has."""
TOO_MANY = 2000
"""Numbers in a sample above the limit."""


def both(processes: Processes) -> tuple[LoggedProcess, LoggedProcess]:
    return processes.device("Base0", *LIMIT), processes.device("Arm0")


def write(processes: Processes, values: dict[str, dict[str, str]]) -> None:
    (processes.folder / "broken.xml").write_text(devices.system(values))


def lost_of(text: str, instance: str) -> int:
    """Return the number of lost samples in a run's report."""
    found = re.search(rf"^{instance} +\w+ +\S+ +\S+ +(\d+)$", text, re.MULTILINE)
    assert found is not None, text
    return int(found.group(1))


def test_a_connection_that_the_sender_in_cpp_ends(processes: Processes) -> None:
    both(processes)
    values = {"size": "3", "big": str(TOO_MANY), "after": "20"}
    write(processes, {"Base0": values})
    run = processes.run("--foreign", "Base0", system="broken.xml")
    name = r"from_base \(Base0.measured to Pilot0.seen\)"
    ended = r"was ended by Base0, perhaps for a sample above its giopMaxMsgSize"
    run.wait_for(lambda: re.search(rf"warning\[SYS0024\]: {name} {ended}", run.text))
    run.says("from_base (Base0.measured to Pilot0.seen) is connected again")
    assert run.end() == 0, run.text
    assert re.search(
        rf"^{name}: ended 1 times, made again 1 times, at least [1-9]\d* samples lost: by Base0",
        run.text,
        re.MULTILINE,
    ), run.text
    assert lost_of(run.text, "Pilot0") >= 1


def test_a_sample_above_the_limit_of_the_receiver_in_cpp(processes: Processes) -> None:
    base, _ = both(processes)
    write(processes, {"Pilot0": {"size": str(300_000)}})
    run = processes.run(system="broken.xml")
    name = r"to_base \(Pilot0.base to Base0.command\)"
    run.wait_for(
        lambda: re.search(
            rf"warning\[SYS0024\]: {name} is lost: a sample of 24000\d\d octets, probably above "
            "giopMaxMsgSize of the other process",
            run.text,
        )
    )
    run.says("to_base (Pilot0.base to Base0.command) is connected again")
    before = base.text.count("command of 3")
    base.says("command of 3", before + 2)
    assert run.end() == 0, run.text
    assert re.search(
        rf"^{name}: ended 1 times, made again 1 times, at least [1-9]\d* samples lost: a sample of",
        run.text,
        re.MULTILINE,
    ), run.text
    assert lost_of(run.text, "Base0") >= 1


def test_all_connections_to_a_frozen_component_end_at_once(
    processes: Processes,
) -> None:
    base, _ = both(processes)
    connections = {
        "one": ("Pilot0.base", "Base0.command"),
        "two": ("Pilot0.arm", "Base0.command"),
    }
    (processes.folder / "frozen.xml").write_text(
        devices.system(connections=connections)
    )
    run = processes.run(system="frozen.xml")
    base.says("command of 3")
    base.process.send_signal(signal.SIGSTOP)
    for name, port in (("one", "base"), ("two", "arm")):
        run.says(
            f"{name} (Pilot0.{port} to Base0.command) is lost: the other process does not answer "
            "in time"
        )
    run.says("Base0 is lost")
    base.process.send_signal(signal.SIGCONT)
    for name, port in (("one", "base"), ("two", "arm")):
        run.says(f"{name} (Pilot0.{port} to Base0.command) is connected again")
    assert run.end() == 0, run.text


@pytest.fixture
def orb() -> Iterator[Orb]:
    made = Orb()
    yield made
    made.close()


def _remote(orb: Orb, names: str, instance: str) -> RemoteRtc:
    found = Naming(orb.orb, names).component(instance, "rtc")
    return RemoteRtc(found, Exported(orb))


def _cut_at_a_port(orb: Orb, processes: Processes) -> None:
    pilot = _remote(orb, processes.names, "Pilot0")
    [port] = [each for each in pilot.ports() if each.name == "Pilot0.seen"]
    [connector] = port.connector_profiles
    # As tools of OpenRTM do: at the first port of the connector.
    assert connector.ports[0]._is_equivalent(port.port_ref)
    pilot.at_port(port, "disconnect", connector.connector_id)


def _cut_on_a_page(orb: Orb, processes: Processes) -> None:
    page = Page(processes.names)
    try:

        def found() -> list[str]:
            names = page.session.remote.connections
            return [each for each in names if "/Base0.measured_" in each]

        until(found)
        [name] = found()
        page.done("connection", name)
    finally:
        page.session.close()


@pytest.mark.parametrize("cut", [_cut_at_a_port, _cut_on_a_page])
def test_a_connection_that_a_user_cuts_stays_cut(
    processes: Processes, orb: Orb, cut: object
) -> None:
    both(processes)
    write(processes, {"Base0": {"size": "3"}})
    run = processes.run(system="broken.xml")
    run.says("Base0 ACTIVE")
    assert callable(cut)
    cut(orb, processes)
    base = _remote(orb, processes.names, "Base0")
    arm = _remote(orb, processes.names, "Arm0")

    def connected(rtc: RemoteRtc) -> list[str]:
        return [c.name for port in rtc.ports() for c in port.connector_profiles]

    assert connected(base) == ["to_base"]
    # The thread that makes connections again has been at work since.
    [port] = [each for each in arm.ports() if each.name == "Arm0.command"]
    [connector] = port.connector_profiles
    arm.at_port(port, "disconnect", connector.connector_id)
    run.says("to_arm (Pilot0.arm to Arm0.command) is connected again")
    # A sample may find the port's object gone before the message of its end comes.
    [ended] = [line for line in run.text.splitlines() if "it is made again" in line]
    assert "was ended by Arm0" in ended or "(OBJECT_NOT_EXIST)" in ended
    assert connected(base) == ["to_base"]
    assert run.end() == 0, run.text
    # The report's latency of chains has the name, too.
    assert "from_base (Base0" not in run.text
