"""Stored parameters that survive the process: the file of a device."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from device_bench import DEVICE, NODE_ID, Bench
from msgspec.structs import replace
from test_canopen_device import Slave

from rtgen.runtime import InitializationError, System
from rtgen.runtime.canopen.node.node import DeviceNode
from rtgen.runtime.canopen.node.parameter_file import ParameterFile, ParameterFileError
from rtgen.runtime.canopen.wire.nmt import NmtCommand

NAME = "drive.json"
SAVE, LOAD = b"save", b"load"


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    inside = tmp_path / "work"
    inside.mkdir()
    monkeypatch.chdir(inside)
    return inside


def powered() -> Bench:
    """Return a node that was switched on, with the values of the file."""
    file = ParameterFile(NAME, DEVICE)
    node = DeviceNode(DEVICE)
    node.store.values, node.store.keep = file.read(), file.write
    node.take_node_id(NODE_ID)
    return Bench(node)


def saved() -> dict[str, Any]:
    bench = powered()
    bench.write(0x2103, 0, 50)
    bench.write(0x607A, 0, 7)
    bench.write(0x1010, 1, SAVE)
    content: dict[str, Any] = json.loads(Path(NAME).read_text(encoding="ascii"))
    return content


def test_stored_values_are_in_force_after_power_on() -> None:
    values = saved()["values"]
    assert set(values) >= {"2103:0", "607A:0"}
    bench = powered()
    assert (bench.node.get(0x2103), bench.node.get(0x607A)) == (50, 7)
    bench.write(0x1011, 3, LOAD)
    bench.command(NmtCommand.RESET_NODE)
    assert (bench.node.get(0x2103), bench.node.get(0x607A)) == (50, 0)
    bench = powered()
    assert (bench.node.get(0x2103), bench.node.get(0x607A)) == (50, 0)
    bench.write(0x1011, 1, LOAD)
    assert powered().node.get(0x2103) == 0


def test_no_file_is_made_before_something_is_stored() -> None:
    powered().write(0x2103, 0, 50)
    assert list(Path.cwd().iterdir()) == []
    saved()
    assert [path.name for path in Path.cwd().iterdir()] == [NAME]


@pytest.mark.parametrize(
    "name",
    ["/tmp/x.json", "../x.json", "a/../../x.json", "x.toml", "", "outside/x.json"],
)
def test_paths_stay_below_the_working_folder(name: str, tmp_path: Path) -> None:
    Path("outside").symlink_to(tmp_path, target_is_directory=True)
    with pytest.raises(ParameterFileError):
        ParameterFile(name, DEVICE)


def _of(**changes: object) -> Callable[[dict[str, Any]], object]:
    return lambda content: content | changes


def _value(key: str, octets: object) -> Callable[[dict[str, Any]], object]:
    return lambda content: content | {"values": {key: octets}}


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        (lambda _: [], "these are not stored parameters"),
        (_of(format="other/1"), "these are not stored parameters"),
        (_of(vendor=1), "parameters of another device: vendor 1, not"),
        (_of(device="Other"), "parameters of another device: device Other, not Bench"),
        (_of(values=3), "it has no values"),
        (_value("2FFF:0", "00"), "no object '2FFF:0' can be stored"),
        (_value("1000:0", "00000000"), "no object '1000:0' can be stored"),
        (_value("2103:0", "0"), "2103:0 cannot have the octets '0'"),
        (_value("2103:0", "00"), "2103:0 cannot have the octets '00'"),
        (_value("2103:0", 7), "2103:0 cannot have the octets '7'"),
    ],
)
def test_a_file_that_is_foreign_or_broken_is_refused(
    change: Callable[[dict[str, Any]], object], reason: str
) -> None:
    content = saved()
    Path(NAME).write_text(json.dumps(change(content)), encoding="ascii")
    with pytest.raises(ParameterFileError) as caught:
        ParameterFile(NAME, DEVICE).read()
    assert str(caught.value).startswith(f"{NAME}: {reason}")


@pytest.mark.parametrize("cut", [0, 1, 20, -3])
def test_a_file_that_was_cut_is_refused(cut: int) -> None:
    saved()
    whole = Path(NAME).read_bytes()
    Path(NAME).write_bytes(whole[:cut])
    with pytest.raises(ParameterFileError, match="not JSON, or not all of it"):
        ParameterFile(NAME, DEVICE).read()


def test_a_file_is_bounded() -> None:
    Path(NAME).write_bytes(b" " * ((1 << 20) + 1))
    with pytest.raises(ParameterFileError, match="over 1048576 octets"):
        ParameterFile(NAME, DEVICE).read()
    Path(NAME).write_bytes(b"[" * 500_000)
    with pytest.raises(ParameterFileError, match="not JSON"):
        ParameterFile(NAME, DEVICE).read()


def test_parameters_of_another_revision_are_foreign() -> None:
    saved()
    newer = replace(DEVICE, revision_number=DEVICE.revision_number + 1)
    with pytest.raises(ParameterFileError, match="another device: revision"):
        ParameterFile(NAME, newer).read()


def test_a_failure_refuses_the_command_and_keeps_what_was_stored() -> None:
    saved()
    bench = powered()
    Path(f".{NAME}.{os.getpid()}").mkdir()
    bench.write(0x2103, 0, 60)
    assert bench.refusal(0x1010, 1, SAVE) == 0x06060000
    assert bench.refusal(0x1011, 1, LOAD) == 0x06060000
    bench.command(NmtCommand.RESET_NODE)
    assert bench.node.get(0x2103) == 50
    assert powered().node.get(0x2103) == 50


def test_a_component_takes_its_file_before_it_boots() -> None:
    saved()
    slave = Slave()
    slave.config.parameter_file = NAME
    with System() as system:
        system.add(slave)
        assert slave.get_object((0x2103, 0)) == 50


def test_a_component_with_a_broken_file_does_not_start() -> None:
    Path(NAME).write_text("{", encoding="ascii")
    slave = Slave()
    slave.config.parameter_file = NAME
    with System() as system, pytest.raises(InitializationError, match="is not JSON"):
        system.add(slave)
    assert slave.reason == f"{NAME}: this is not JSON, or not all of it"
    assert Path(NAME).read_text(encoding="ascii") == "{"
