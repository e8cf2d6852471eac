"""PositionInput alone: its three inputs, the protocol of paths, the end."""

from __future__ import annotations

import io
import os
from pathlib import Path

import pytest
from component_bench import Bench
from patience import until

from refnav.position_input import PositionInput
from refrobots import iis, rtc
from rtgen.runtime import Component, LifeCycleState, SimulatedClock, System

FINISH = rtc.TimedState(data=iis.State.FINISH)


def bench(**parameters: str) -> Bench:
    bench = Bench(PositionInput("PositionInput0"), 10.0)
    bench.set(**parameters)
    return bench


def goals(bench: Bench) -> list[tuple[list[int], float, float, float]]:
    return [
        (list(p.id), p.data.position.x, p.data.position.y, p.data.heading)
        for p in bench.sent(".positon")
    ]


def write(folder: Path, text: str) -> dict[str, str]:
    (folder / "tour.txt").write_text(text, encoding="utf-8")
    return {"input": "file", "input_file": str(folder / "tour.txt")}


def test_the_parameters_are_one_goal() -> None:
    b = bench(input="parameters")
    b.activate()
    b.run(1.0)
    assert goals(b) == [([], 3.4, 7.7, -1.57)]
    assert b.component.observables["goal"]() == (3.4, 7.7, -1.57)
    b.send("status", FINISH)
    b.run(0.1)
    assert b.state is LifeCycleState.ERROR_STATE
    assert b.component.reason == "all commands are carried out"


def test_only_the_pose_of_a_goal_is_filled() -> None:
    b = bench(input="parameters")
    b.activate()
    b.run(1.0)
    # The first sample was sent at once.
    [sample] = b.sent(".positon")
    assert (sample.tm.sec, sample.tm.nsec, sample.id, sample.error) == (0, 0, [], [])


def test_a_path_of_a_file_carries_the_places_of_its_points(tmp_path: Path) -> None:
    b = bench(**write(tmp_path, "path 1 0 0; 2 0 0; 3 0 0; 3 1 1.5\n"))
    b.activate()
    b.run(0.1)
    assert [(p[0], p[1]) for p in goals(b)] == [
        ([100], 1),
        ([101], 2),
        ([101], 3),
        ([102], 3),
    ]
    assert b.component.observables["goal"]() == (3, 1, 1.5)


def test_commands_go_out_one_after_the_other(tmp_path: Path) -> None:
    b = bench(**write(tmp_path, "goal 1 0 0\ngoal 2 0 0\n"))
    b.activate()
    b.run(5.0)
    assert [p[1] for p in goals(b)] == [1]
    b.send("status", rtc.TimedState(data=iis.State.TURNING))
    b.run(0.1)
    assert goals(b) == []
    b.send("status", FINISH)
    b.run(0.1)
    assert [p[1] for p in goals(b)] == [2]
    assert b.state is LifeCycleState.ACTIVE_STATE
    b.send("status", FINISH)
    b.run(0.1)
    assert b.state is LifeCycleState.ERROR_STATE


def test_a_finish_from_before_the_command_does_not_count(tmp_path: Path) -> None:
    b = bench(**write(tmp_path, "goal 1 0 0\n"))
    b.send("status", FINISH)
    b.activate()
    b.run(1.0)
    assert b.state is LifeCycleState.ACTIVE_STATE


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("path 1 2 3\n", "tour.txt:1: a path needs two or more waypoints"),
        ("goal 1 2 3\nhello\n", "tour.txt:2: 'hello' is not a command"),
        ("", "tour.txt: holds no command"),
        (None, "No such file"),
    ],
)
def test_a_bad_file_is_an_error_with_a_reason(
    tmp_path: Path, text: str | None, reason: str
) -> None:
    b = bench(input="file", input_file="tour.txt")
    b.component.folder = tmp_path
    if text is not None:
        (tmp_path / "tour.txt").write_text(text, encoding="utf-8")
    b.activate()
    assert b.state is LifeCycleState.ERROR_STATE
    assert reason in b.component.reason
    assert goals(b) == []


def on_console(stream: io.TextIOBase) -> Bench:
    b = bench(input="console")
    assert isinstance(b.component, PositionInput)
    b.component.console = stream
    b.activate()
    return b


def test_the_console_takes_goals_paths_and_the_set_path(
    capsys: pytest.CaptureFixture[str],
) -> None:
    b = on_console(io.StringIO("goal 1 2 3\n\npath 1 0 0\nwhat?\npath\n"))
    b.component.console_reader.wait_for_end()
    b.run(0.1)
    assert goals(b) == [([], 1, 2, 3)]
    b.send("status", FINISH)
    b.run(0.1)
    assert [p[0] for p in goals(b)] == [[100], [101], [102]]
    b.send("status", FINISH)
    b.run(0.1)
    assert b.state is LifeCycleState.ERROR_STATE
    captured = capsys.readouterr()
    assert captured.out == ""
    assert "'goal X Y TH'" in captured.err
    assert "a path needs two or more waypoints" in captured.err
    assert "'what?' is not a command" in captured.err


def test_an_execution_does_not_wait_for_the_console() -> None:
    read, write_end = os.pipe()
    with os.fdopen(read, encoding="utf-8") as stream:
        b = on_console(stream)
        b.run(10.0)
        assert b.state is LifeCycleState.ACTIVE_STATE
        os.write(write_end, b"goal 1 2 3\n")
        os.close(write_end)
        b.component.console_reader.wait_for_end()
        b.run(0.1)
        assert goals(b) == [([], 1, 2, 3)]
        b.deactivate()
        assert b.component.console_reader is None


def test_a_console_that_fails_is_not_the_end_of_the_work() -> None:
    stream = io.StringIO("goal 1 2 3\n")
    stream.close()
    b = on_console(stream)

    def has_failed() -> bool:
        b.run(0.1)
        return b.state is LifeCycleState.ERROR_STATE

    until(has_failed)
    assert b.component.reason.startswith("on_execute (")
    assert "): OSError: console: " in b.component.reason


def test_what_is_refused_is_sent_again(tmp_path: Path) -> None:
    points = "; ".join(f"{k} 0 0" for k in range(50))
    component = PositionInput("PositionInput0")
    taker = Component("Taker0")
    goal = taker.add_in_port("goal", iis.TimedPose2D)
    system = System(SimulatedClock())
    system.add(component, 10.0)
    system.add(taker, 10.0)
    settings = {"buffer.length": "7", "buffer.write.full_policy": "do_nothing"}
    properties = {f"dataport.inport.{key}": value for key, value in settings.items()}
    system.connect(("PositionInput0", ".positon"), ("Taker0", "goal"), properties)
    for name, text in write(tmp_path, f"path {points}\n").items():
        system.configure("PositionInput0", name, text)
    system.activate("PositionInput0")
    taken = []
    for cycle in range(20):
        system.run(until_ns=cycle * 100_000_000)
        while goal.is_new() and (sample := goal.read()) is not None:
            taken.append((sample.id[0], sample.data.position.x))
    assert taken == [(100, 0.0), *((101, float(k)) for k in range(1, 49)), (102, 49.0)]
