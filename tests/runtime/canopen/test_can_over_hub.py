"""`rtgen can` with a hub, slaves and commands in processes of their own."""

from __future__ import annotations

import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from can_nodes import SPECS, nodes
from hub_process import HubProcess
from json_schemas import valid
from patience import PATIENCE, until

from rtgen.cli import run

pytestmark = pytest.mark.waits

LINKED = str(SPECS / "pdo_linking.toml")
PAIR = {1: "motor_core_unit", 2: "f_palette"}
MARK = b"< send 7E0 0 >"
"""A frame that no node sends."""


def access(hub: HubProcess) -> list[str]:
    return ["--interface", "socketcand", "--option", f"port={hub.port}"]


@contextmanager
def started(*arguments: str) -> Iterator[subprocess.Popen[str]]:
    """Yield a command in a process, which is killed at the end if it still runs."""
    process = subprocess.Popen(
        [sys.executable, "-m", "rtgen", "can", *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    try:
        yield process
    finally:
        if process.poll() is None:
            process.kill()
        process.communicate()


def ended(process: subprocess.Popen[str]) -> tuple[str, str]:
    """Return the output of a process that was ended by Ctrl-C."""
    process.send_signal(signal.SIGINT)
    output = process.communicate(timeout=PATIENCE)
    assert process.returncode == 0, output[1]
    return output


def frames(text: str) -> list[dict[str, Any]]:
    found = [valid(line, "can.schema.json", "frame") for line in text.splitlines()]
    return [{k: v for k, v in line.items() if k != "time"} for line in found]


def between(found: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return the frames from the first command to the last answer."""
    kinds = [line["kind"] for line in found]
    first, last = kinds.index("nmt"), len(kinds) - kinds[::-1].index("sdo")
    return found[first:last]


@pytest.mark.nightly
def test_a_record_of_a_network_shows_what_was_live(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "run.log"
    with HubProcess() as hub, nodes(link := hub.link(), PAIR) as made:
        bus = access(hub)
        shown = ["--bus", LINKED]
        with (
            started("record", str(path), *bus) as recorder,
            started("monitor", "--json", *shown, *bus) as monitor,
        ):
            assert recorder.stderr is not None
            assert monitor.stdout is not None
            assert "recording" in recorder.stderr.readline()
            lines = [monitor.stdout.readline()]
            assert run(["can", "send", "nmt start all", *shown, *bus]) == 0
            sdo = ["can", "sdo", "--no-look", *shown, *bus]
            assert run([*sdo, "write", "motor", "Producer_heartbeat_time", "0"]) == 0
            assert run([*sdo, "write", "palette", "1017", "0"]) == 0
            assert run([*sdo, "read", "motor", "Manufacturer_device_name"]) == 0
            assert capfd.readouterr().out == "Motor core unit\n"
            with link.lock:
                made[2].set(0x6401, 1, 1234)
                link.send(made[2].flush(link.now()), made[2])
            assert run([*sdo, "read", "palette", "1018:2"]) == 0
            # A frame after the last answer, until both have received it.
            with hub.raw() as end:
                until(lambda: end.sendall(MARK) or " 7E0#" in path.read_text())
            while '"7E0"' not in lines[-1]:
                lines.append(monitor.stdout.readline())
            live = frames("".join(lines))
            ended(monitor)
            _, errors = ended(recorder)
    assert f"frames in {path}" in errors
    capfd.readouterr()
    assert run(["can", "replay", str(path), "--decode", "--json", *shown]) == 0
    again = frames(capfd.readouterr().out)
    live, again = between(live), between(again)
    assert again == live
    values = {
        field["name"]: field["value"]
        for line in live
        if line["kind"] == "tpdo2" and line["name"] == "palette"
        for field in line["values"]
    }
    assert values["Analogue_input_1"] == 1234
    assert live[-1]["text"].startswith("read answer 1018:2 Product_code = 0x")


@pytest.mark.sampled(0)
def test_the_end_of_the_hub_is_reported(tmp_path: Path) -> None:
    path = tmp_path / "run.blf"
    with HubProcess() as hub, started("record", str(path), *access(hub)) as recorder:
        assert recorder.stderr is not None
        assert "recording" in recorder.stderr.readline()
        assert run(["can", "send", "181#01", *access(hub)]) == 0
        assert run(["can", "send", "181#R", *access(hub)]) == 3
        hub.end(signal.SIGKILL)
        _, errors = recorder.communicate(timeout=PATIENCE)
    assert recorder.returncode == 3
    assert "error[ENV0001]: the bus is gone" in errors
    assert run(["can", "replay", str(path), "--decode", "--json"]) == 0


def test_scan_over_the_hub(capfd: pytest.CaptureFixture[str]) -> None:
    with HubProcess() as hub, nodes(hub.link(), PAIR):
        scan = ["can", "scan", "--no-lss", "--bus", LINKED, *access(hub)]
        assert run(scan) == 0
    assert capfd.readouterr().out.count("as described") == 2
