"""Runs of the reference build, recorded, inspected, and replayed in part."""

from __future__ import annotations

import json
import random
from pathlib import Path
from typing import Any

import pytest
import seeds
from json_schemas import valid

from refrobots import iis
from rtgen.cli import run as rtgen
from rtgen.tools.recording.events import Log
from rtgen.tools.recording.mcap_reader import McapFile

SPECS = Path(__file__).parents[2] / "specs"
GOAL = SPECS / "navigation" / "rh3_goal.xml"
DRIVES = SPECS / "canopen" / "fourx.xml"
BOARD = SPECS / "tecs" / "rh3_board.xml"
INSTANCES = (
    "PositionInput0",
    "OmniTo2WD0",
    "Navigation0",
    "PathFollower0",
    "RefHardRh30",
    "Odometry0",
)


def recorded(system: Path, path: Path, *arguments: str, until: str = "1") -> Path:
    command = ["run", str(system), "--until", until, "-q", "--record", str(path)]
    assert rtgen([*command, *arguments]) == 0
    return path


@pytest.fixture(scope="module")
def goal(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a second of RH3, with its log beside it."""
    path = tmp_path_factory.mktemp("goal") / "goal.mcap"
    return recorded(GOAL, path, "--log", str(path.with_suffix(".jsonl")))


def same(message: Any, logged: Any) -> bool:
    """Return whether a message equals a line of the log, which shows enumerators by name."""
    if isinstance(message, dict) and isinstance(logged, dict):
        return message.keys() == logged.keys() and all(
            same(message[key], logged[key]) for key in message
        )
    if isinstance(message, int) and isinstance(logged, str):
        enums = (iis.State, iis.TravelMode)
        return any(
            logged in each.__members__ and each[logged] == message for each in enums
        )
    return bool(message == logged)


@pytest.mark.sampled(0)
def test_every_message_of_rh3_is_what_the_log_holds(goal: Path) -> None:
    lines = goal.with_suffix(".jsonl").read_text().splitlines()
    logged = [json.loads(line) for line in lines]
    chosen = Log(goal).events(lambda head: head["event"] in ("state", "sample"))
    messages = [*chosen]
    assert len(messages) == len(logged) > 2000
    assert all(map(same, messages, logged))


def of_instances(path: Path, present: set[str]) -> list[tuple[str, str, int, bytes]]:
    """Return the samples of components, octet by octet."""
    return [
        (
            message.channel.get("instance"),
            message.channel.topic,
            message.time,
            message.data,
        )
        for message in McapFile(path).messages()
        if message.channel.get("kind") == "sample"
        and message.channel.get("instance") in present
    ]


def replayed(recording: Path, system: Path, present: set[str], path: Path) -> None:
    """Replay into some components of a system, and compare the written samples."""
    command = ["replay", str(recording), "--into", str(system), "-q"]
    only = ["--only", ",".join(sorted(present)), "--record", str(path)]
    assert rtgen([*command, *only]) == 0
    expected = of_instances(recording, present)
    assert of_instances(path, present) == expected
    assert expected


@pytest.mark.sampled(2)
@pytest.mark.parametrize("instance", INSTANCES)
def test_each_component_alone_writes_what_it_wrote(
    goal: Path, tmp_path: Path, instance: str
) -> None:
    # The status of OmniTo2WD0 alone comes at the goal, its path at the start.
    replayed(goal, GOAL, {instance}, tmp_path / "again.mcap")


def test_any_part_of_the_system_writes_what_it_wrote(
    goal: Path, tmp_path: Path
) -> None:
    for case in seeds.cases(4):
        draw = random.Random(case)
        present = set(draw.sample(INSTANCES, draw.randrange(2, 6)))
        replayed(goal, GOAL, present, tmp_path / f"{case}.mcap")


def test_the_whole_system_gives_the_same_file(goal: Path, tmp_path: Path) -> None:
    again = tmp_path / "again.mcap"
    assert (
        rtgen(["replay", str(goal), "--into", str(GOAL), "-q", "--record", str(again)])
        == 0
    )
    assert again.read_bytes() == goal.read_bytes()


@pytest.mark.sampled(0)
def test_drives_on_a_bus_are_replayed_with_their_bus(tmp_path: Path) -> None:
    """All components on the bus run; navigation is replayed."""
    recording = recorded(DRIVES, tmp_path / "drives.mcap", until="0.6")
    text = DRIVES.read_text()
    found = {event["instance"] for event in Log(recording).events(is_component)}
    present = {name for name in found if "Wheel" in name or "Drive" in name}
    present |= {"CanopenManager0", "RefHardFourX0"}
    assert all(name in text for name in present)
    replayed(recording, DRIVES, present, tmp_path / "again.mcap")
    frames = [*Log(recording).events(lambda head: head["event"] == "frame")]
    assert len(frames) > 500
    assert {frame["bus"] for frame in frames} == {"can0"}


def is_component(head: Any) -> bool:
    return bool(head["event"] == "component")


def test_calls_of_a_board_are_recorded(tmp_path: Path) -> None:
    recording = recorded(BOARD, tmp_path / "board.mcap", until="0.5")
    calls = [*Log(recording).events(lambda head: head["event"] == "call")]
    assert len(calls) > 10
    assert {call["error"] for call in calls} == {""}
    assert all(call["request"] for call in calls)
    assert sum(bool(call["reply"]) for call in calls) > 10


# Commands


def test_log_commands(
    goal: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    lines = goal.with_suffix(".jsonl")
    assert rtgen(["log", "info", str(goal)]) == 0
    shown = capfd.readouterr().out
    assert "goal.mcap: MCAP, simulated time\n" in shown
    assert (
        "sample      PathFollower0.velocity      IIS::TimedVelocity2D   1001" in shown
    )
    assert rtgen(["log", "info", str(lines)]) == 0
    assert "goal.jsonl: JSON lines" in capfd.readouterr().out
    for file, form in (goal, "mcap"), (lines, "json-lines"):
        assert rtgen(["log", "info", "--json", str(file)]) == 0
        described = valid(capfd.readouterr().out, "log.schema.json")
        assert (described["form"], described["whole"]) == (form, True)
        [velocity] = [
            s for s in described["sources"] if s["of"] == "PathFollower0.velocity"
        ]
        assert (velocity["count"], velocity["to"]) == (1001, 10**9)
    for file in (goal, lines):
        name = "Odometry0.OdometryPosition"
        assert rtgen(["log", "cat", str(file), name]) == 0
        printed = [json.loads(line) for line in capfd.readouterr().out.splitlines()]
        assert [event["t"] for event in printed] == [*range(0, 10**9, 10**7)]
        assert rtgen(["log", "csv", str(file), f"{name}.data.heading"]) == 0
        table = capfd.readouterr().out.splitlines()
        unit = " [rad]" if file == goal else ""  # JSON lines have no units
        assert table[0] == f"t,{name}.data.heading{unit}"
        assert len(table) == 101
    picture = tmp_path / "velocity.svg"
    arguments = ["PathFollower0.velocity", "-o", str(picture)]
    assert rtgen(["log", "plot", str(goal), *arguments]) == 0
    assert "[m/s]" in picture.read_text() or picture.stat().st_size > 1000
    assert rtgen(["log", "diff", str(goal), str(lines), "PathFollower0"]) == 0
    assert "1004 events are equal; 0 of 2" in capfd.readouterr().err


def test_diff_shows_the_first_difference(
    goal: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    setting = ("--set", "PathFollower0.max_w=0.001")
    other = recorded(GOAL, tmp_path / "other.mcap", *setting)
    assert rtgen(["log", "diff", str(goal), str(other)]) == 1
    shown = capfd.readouterr().out
    assert "parameter PathFollower0: at 0.000000 s: value is '" in shown
    assert "sample PathFollower0.velocity: at " in shown


def test_replay_prints_events(goal: Path, capfd: pytest.CaptureFixture[str]) -> None:
    assert rtgen(["replay", str(goal), "--until", "0.001", "--rate", "1000"]) == 0
    printed = [json.loads(line) for line in capfd.readouterr().out.splitlines()]
    assert {event["t"] for event in printed} == {0, 10**6}


@pytest.mark.parametrize(
    ("arguments", "what", "code"),
    [
        (["replay", "{goal}", "--only", "Odometry0"], "--into", 2),
        (["replay", "{goal}.jsonl", "--into", str(GOAL)], "is not an MCAP file", 2),
        (["replay", "{goal}", "--into", str(GOAL), "--only", "X"], "X", 2),
        (["log", "csv", "{goal}", "Odometry0.Odometry"], "did you mean", 2),
        (
            ["log", "csv", "{goal}", "Odometry0.OdometryPosition.data.heding"],
            "did you mean 'heading'?",
            2,
        ),
        (["log", "csv", "{goal}", "Odometry0"], "names no value of a port", 2),
        (["log", "info", str(GOAL)], "neither MCAP nor JSON lines", 2),
        (["log", "cat", "missing.mcap"], "cannot read missing.mcap", 3),
        (["run", str(GOAL), "--until", "1", "--compression", "lz4"], "--record", 2),
        (
            ["run", str(GOAL), "--until", "1", "--record", "{goal}/a.mcap"],
            "cannot write",
            3,
        ),
    ],
)
def test_refusals(
    goal: Path,
    capfd: pytest.CaptureFixture[str],
    arguments: list[str],
    what: str,
    code: int,
) -> None:
    lines = str(goal.with_suffix(".jsonl"))
    given = [
        a.replace("{goal}.jsonl", lines).replace("{goal}", str(goal)) for a in arguments
    ]
    assert rtgen(given) == code
    assert what in capfd.readouterr().err


@pytest.mark.parametrize("command", ["run", "ui", "replay"])
def test_without_the_library_nothing_begins(
    command: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    """No component is created, and the results of an earlier run stay."""
    monkeypatch.setattr(
        "rtgen.tools.recording.mcap_writer.find_spec", lambda name: None
    )
    log = tmp_path / "run.jsonl"
    log.write_text("before", encoding="utf-8")
    files = ["--record", str(tmp_path / "a.mcap"), "--log", str(log)]
    given = {
        "run": [str(GOAL), "--until", "1", *files],
        "ui": [str(GOAL), "--no-open", *files[:2]],
        "replay": [str(tmp_path / "b.mcap"), "--into", str(GOAL), *files],
    }[command]
    (tmp_path / "b.mcap").write_bytes(b"")
    assert rtgen([command, *given]) == 3
    assert "recordings need mcap" in capfd.readouterr().err
    assert log.read_text(encoding="utf-8") == "before"
    assert not (tmp_path / "a.mcap").exists()


@pytest.mark.parametrize("option", ["--csv", "--log", "--plot", "--record"])
def test_no_file_is_emptied_if_another_cannot_be_written(
    option: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    files = {
        "--csv": tmp_path / "run.csv",
        "--log": tmp_path / "run.jsonl",
        "--plot": tmp_path / "run.svg",
        "--record": tmp_path / "run.mcap",
    }
    for file in files.values():
        file.write_text("before", encoding="utf-8")
    impossible = files.pop(option) / "below_a_file"
    given = {**files, option: impossible.with_suffix(".svg")}
    words = [str(word) for pair in given.items() for word in pair]
    assert rtgen(["run", str(GOAL), "--until", "1", *words]) == 3
    assert f"cannot write {given[option]}" in capfd.readouterr().err
    assert {file.read_text(encoding="utf-8") for file in files.values()} == {"before"}


def test_no_command_overwrites_what_it_reads(
    goal: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    recording, system = tmp_path / "goal.mcap", tmp_path / "goal.xml"
    recording.write_bytes(goal.read_bytes())
    system.write_bytes(GOAL.read_bytes())
    link = tmp_path / "link.mcap"
    link.symlink_to(recording)
    into = ["replay", str(recording), "--into", str(system)]
    port = ["log", "csv", str(recording), "Odometry0.currentPosition"]
    for words, output in [
        (["run", str(system), "--until", "1", "--log"], system),
        ([*into, "--record"], recording),
        ([*into, "--record"], link),
        ([*into, "--log"], system),
        ([*port, "-o"], recording),
    ]:
        assert rtgen([*words, str(output)]) == 2, words
        message = f"{words[-1]} would overwrite {output}, which is read"
        assert message in capfd.readouterr().err
    assert recording.read_bytes() == goal.read_bytes()
    assert system.read_bytes() == GOAL.read_bytes()
