"""The embedded layer: the same behaviours on the small runtime and on the embedded one."""

from __future__ import annotations

import ast
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from micropython import micropython

from refnav.contents_interpretation import ContentsInterpretation
from refnav.hokuyo_aist import HokuyoAist
from refnav.ucode_reader import UcodeReader
from refnav.ucode_settlement import UcodeSettlement
from refrobots import iis
from rtgen.runtime import (
    SECOND,
    Component,
    Record,
    SampleRecord,
    SimulatedClock,
    System,
)

ROOT = Path(__file__).parents[2]
DRIVER = Path(__file__).with_name("small_driver.py")
BEHAVIOURS = (
    *("contents_interpretation", "hokuyo_aist", "rays", "recent"),
    *("ucode_reader", "ucode_settlement"),
)
ALLOWED = {"sys", "struct", "math", "time", "array", "collections"}


@pytest.fixture(scope="module")
def board(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the files for a board: the small tree and the behaviours."""
    folder = tmp_path_factory.mktemp("small")
    command = [sys.executable, "-m", "rtgen", "generate", "--target", "small"]
    command += [f"specs/embedded/{name}.idl" for name in _definitions()]
    command += ["-I", "specs/idl", "-o", str(folder), "--quiet", "--no-cache"]
    subprocess.run(command, cwd=ROOT, check=True)
    behaviours = folder / "board" / "refnav"
    shutil.copytree(folder / "generated" / "small", folder / "board")
    behaviours.mkdir()
    (behaviours / "__init__.py").write_text("", encoding="utf-8")
    for name in BEHAVIOURS:
        shutil.copy(ROOT / "reference" / "refnav" / f"{name}.py", behaviours)
    return folder / "board"


def _definitions() -> list[str]:
    return sorted(path.stem for path in (ROOT / "specs/embedded").glob("*.idl"))


def on_board(board: Path, interpreter: list[str], **environment: str) -> list[str]:
    command = [*interpreter, str(DRIVER)]
    result = subprocess.run(
        command,
        cwd=board,
        env={**os.environ, **environment},
        check=False,
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert result.returncode == 0, result.stdout + result.stderr
    return result.stdout.splitlines()


@pytest.fixture(scope="module")
def small(board: Path) -> list[str]:
    return on_board(board, [sys.executable, "-S"], PYTHONPATH=str(board))


@pytest.fixture(scope="module")
def embedded() -> list[str]:
    """Return the output of the driver for the embedded runtime."""
    lines = []

    def note(record: Record) -> None:
        if isinstance(record, SampleRecord) and record.instance != "Peer0":
            octets = record.value.to_cdr(little_endian=True).hex()
            lines.append(f"{record.time} {record.instance}.{record.port} {octets}")

    system = System(SimulatedClock())
    components = (
        *(HokuyoAist(), UcodeReader()),
        *(UcodeSettlement(), ContentsInterpretation()),
    )
    for component in components:
        system.add(component, component.profile.rate)
        system.activate(component.instance_name)
    peer = Component("Peer0")
    source = peer.add_out_port("pose", iis.TimedPose2D)
    system.add(peer, 1.0)
    two = {"dataport.inport.buffer.length": "2"}
    for sender, receiver in (
        (("Peer0", "pose"), ("HokuyoAist0", "pose")),
        (("Peer0", "pose"), ("UcodeReader0", "pose")),
        (("UcodeReader0", "sightings"), ("UcodeSettlement0", "sightings")),
        (("UcodeSettlement0", "record"), ("ContentsInterpretation0", "record")),
    ):
        system.connect(sender, receiver, two)
    system.configure("UcodeReader0", "markers", "1 1 0; 2 2 0.5; ff 3 0")
    records = "1 1 0 room kitchen; 2 2 0.5 door front door"
    system.configure("UcodeSettlement0", "records", records)
    system.add_listener(note)
    for place in range(8):
        pose = iis.TimedPose2D()
        pose.tm.sec = place
        pose.data.position.x = 0.4 * place
        source.write(pose)
        system.run((place + 1) * SECOND)
    for component in components:
        name = component.instance_name
        ticks = system.context(name).participants[0].ticks
        lines.append(f"{name} {system.state(name).value} {ticks}")
    return lines


@pytest.mark.nightly
def test_every_sample_is_the_same_at_the_same_time(
    small: list[str], embedded: list[str]
) -> None:
    assert small[: len(embedded)] == embedded
    assert sum("ContentsInterpretation0.contents" in line for line in small) == 5
    assert sum("UcodeReader0.sightings" in line for line in small) == 8


@pytest.mark.sampled(0)
def test_cycles_cost_no_memory(small: list[str]) -> None:
    assert small[-1] == "blocks 0"


def test_nothing_else_is_imported(board: Path) -> None:
    """Neither threads nor enum nor dataclasses: only modules of every MicroPython."""
    imported = set()
    for file in board.rglob("*.py"):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import):
                imported |= {alias.name for alias in node.names}
            elif isinstance(node, ast.ImportFrom) and not node.level:
                imported.add(node.module or "")
    others = {name.partition(".")[0] for name in imported}
    assert others - {"refnav", "refrobots", "rtgen"} <= ALLOWED
    assert "struct" in others


def test_only_what_micropython_reads_is_written(board: Path) -> None:
    for file in [*board.rglob("*.py"), DRIVER]:
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            assert not isinstance(node, ast.Match), file
            if isinstance(node, ast.Tuple | ast.List | ast.Set):
                assert not any(isinstance(i, ast.Starred) for i in node.elts), file
            if isinstance(node, ast.Dict):
                assert None not in node.keys, file
            if isinstance(node, ast.arguments):
                assert not node.posonlyargs, file


def test_micropython_gives_the_same(board: Path, embedded: list[str]) -> None:
    printed = micropython(DRIVER.read_text("utf-8"), board).splitlines()

    def comparable(lines: list[str]) -> list[list[str]]:
        # Sines of another C library may differ in the last bit, so only the length of scans is
        # compared.
        words = [line.split() for line in lines[: len(embedded)]]
        return [
            [*w[:2], str(len(w[2]))] if w[1] == "HokuyoAist0.range" else w
            for w in words
        ]

    assert comparable(printed) == comparable(embedded)
