"""Services of a network: SYNC, emergencies, consumed heartbeats, and values that nodes refuse."""

from __future__ import annotations

from pathlib import Path

import pytest
from start_up_runs import network_of, problems, problems_of_devices, read
from test_identifiers import eds

from rtgen.compiler.layouts.can_messages import messages
from rtgen.compiler.layouts.can_startup import start_up
from rtgen.compiler.model.can_bus import Bus
from rtgen.runtime.canopen.wire.frames import CobId

OBJECTS = {
    "1005": "0x80",
    "1006": "0",
    "1012": "0x100",
    "1014": "$NODEID+0x80",
    "1017": "100",
    "1019": "0",
}


def bus_of(
    folder: Path, values: str, head: str = "", nodes: int = 1, **objects: str
) -> tuple[Bus | None, list[str]]:
    """Return the network of nodes 5 and 6, and the codes of errors and of EDS07."""
    path = eds(folder, OBJECTS | {key[1:]: text for key, text in objects.items()})
    path.rename(folder / "sampler.eds")
    text = f"[bus]\nbit_rate = 500\n{head}\n[device.s]\neds = 'sampler.eds'\n"
    for number in range(nodes):
        text += f"[node.n{number}]\ndevice = 's'\nid = {5 + number}\n"
        text += f"[node.n{number}.values]\n{values}\n"
    (folder / "bus.toml").write_text(text)
    bus, findings = read(folder / "bus.toml")
    if bus is not None:
        assert not list(problems(bus, findings))
        assert not list(problems_of_devices(bus, findings))
    return bus, [d.code for d in findings if d.code.startswith("EDS07")]


def written(bus: Bus, place: int = 0) -> list[tuple[str, str]]:
    return [
        (f"{w.variable.index:04X}:{w.variable.subindex:X}", w.value.hex())
        for w in start_up(bus.nodes[place])
    ]


@pytest.mark.parametrize(
    "value",
    [
        '"1014" = 0', '"1014" = 0x10', '"1014" = 0x585', '"1014" = 0x1234',
        '"1005" = 0', '"1005" = 0x40000000', '"1005" = 0x101', '"1012" = 0x80000000',
        '"1800:1" = 0', '"1800:1" = 0x605', '"1400:1" = 0x701', '"1019" = 1',
        '"1019" = 241', '"1800:2" = 245', '"1400:2" = 252', '"1400:2" = 241',
    ],
)  # fmt: skip
def test_values_that_each_node_refuses_are_errors(value: str, tmp_path: Path) -> None:
    assert bus_of(tmp_path, value)[1] == ["EDS0704"]


@pytest.mark.parametrize("value", [9, 101])
def test_values_beyond_limits_are_errors(value: int, tmp_path: Path) -> None:
    folder = tmp_path / "limits"
    folder.mkdir()
    path = eds(folder, {"2F00": "20"})
    limits = "LowLimit=10\nHighLimit=100\n"
    path.rename(folder / "sampler.eds")
    with (folder / "sampler.eds").open("a") as file:
        file.write(limits)
    (folder / "bus.toml").write_text(
        "[bus]\nbit_rate = 500\n[device.s]\neds = 'sampler.eds'\n"
        f"[node.n]\ndevice = 's'\nid = 5\n[node.n.values]\n'2F00' = {value}\n"
    )
    bus, findings = read(folder / "bus.toml")
    assert bus is None
    [message] = [d.message for d in findings if d.code == "EDS0704"]
    assert "LowLimit 10" in message or "HighLimit 100" in message


def test_emergencies_with_another_identifier_are_those_of_the_network(
    tmp_path: Path,
) -> None:
    bus, codes = bus_of(tmp_path, '"1014" = "$NODEID+0x6A0"', nodes=2)
    assert bus is not None
    assert codes == []
    assert [node.emergency for node in network_of(bus).nodes] == [0x6A5, 0x6A6]
    named = {m.name: m.identifier for m in messages(bus)}
    assert named["n0 emergency"] == 0x6A5
    assert written(bus)[:3] == [
        ("1014:0", "85000080"),
        ("1014:0", "a5060080"),
        ("1014:0", "a5060000"),
    ]


def test_emergencies_that_are_off_have_no_messages(tmp_path: Path) -> None:
    bus, _ = bus_of(tmp_path, '"1014" = 0x80000000')
    assert bus is not None
    [node] = network_of(bus).nodes
    assert not CobId(node.emergency_cob_id).valid
    assert "n0 emergency" not in {m.name for m in messages(bus)}


@pytest.mark.parametrize("value", ["0x80", "0x6A0", "0x86", "0x285"])
def test_an_identifier_of_two_services_is_an_error(value: str, tmp_path: Path) -> None:
    """That of SYNC, of emergencies of another node, or of a PDO."""
    assert "EDS0706" in bus_of(tmp_path, f'"1014" = {value}', nodes=2)[1]


@pytest.mark.parametrize("default", ["0x90", "0x40000080", "0", ""])
def test_sync_is_heard_whatever_1005_is_by_default(
    default: str, tmp_path: Path
) -> None:
    bus, codes = bus_of(
        tmp_path, '"1800:2" = 1', "sync = 0.02", o1005=default, o1006="1000"
    )
    assert bus is not None
    assert codes == []
    assert network_of(bus).sync_cob_id == 0x80
    expected = {"0x90": ["80000000"], "0x40000080": ["80000000"]}
    found = [octets for number, octets in written(bus) if number == "1005:0"]
    assert found == expected.get(default, [])


def test_all_nodes_may_have_another_sync_in_common(tmp_path: Path) -> None:
    values = '"1005" = 0x90\n"1800:2" = 1'
    bus, codes = bus_of(tmp_path, values, "sync = 0.02", nodes=2)
    assert bus is not None
    assert codes == []
    assert network_of(bus).sync_cob_id == 0x90
    assert {m.name: m.identifier for m in messages(bus)}["SYNC"] == 0x90


@pytest.mark.sampled(4)
@pytest.mark.parametrize("counter", [0, 10])
@pytest.mark.parametrize("default", ["0", "10", "20"])
@pytest.mark.parametrize("period", ["0", "1000"])
def test_the_counter_of_sync_is_that_of_the_network(
    counter: int, default: str, period: str, tmp_path: Path
) -> None:
    head = "sync = 0.02" + (f"\nsync_counter = {counter}" if counter else "")
    bus, codes = bus_of(tmp_path, "", head, o1019=default, o1006=period)
    assert bus is not None
    assert codes == []
    found = [octets for number, octets in written(bus) if number == "1019:0"]
    assert found == ([] if int(default) == counter else [f"{counter:02x}"])


def test_values_that_contradict_the_sync_of_the_network_are_errors(
    tmp_path: Path,
) -> None:
    bus, codes = bus_of(tmp_path, '"1019" = 5', "sync = 0.02\nsync_counter = 10")
    assert (bus, codes) == (None, ["EDS0713"])
