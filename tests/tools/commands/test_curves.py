"""`rtgen run --plot INSTANCE.PORT` and `--csv INSTANCE.PORT`: values of ports over time."""

from __future__ import annotations

import csv
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from xml.etree import ElementTree

import pytest

from rtgen.cli import run

ROOT = Path(__file__).parents[3]
SYSTEM = str(ROOT / "specs/navigation/rh3_goal.xml")
SHORT = ["run", SYSTEM, "--until", "0.5"]


@pytest.fixture(scope="module")
def project(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with the reference tree, whose definitions are read once."""
    folder = tmp_path_factory.mktemp("project")
    (folder / "rtgen.toml").write_text((ROOT / "rtgen.toml").read_text())
    for name in ("specs", "src", "generated"):
        (folder / name).symlink_to(ROOT / name)
    return folder


@pytest.fixture(autouse=True)
def _folder(project: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    before = {*project.iterdir()}
    monkeypatch.chdir(project)
    yield
    for each in {*project.iterdir()} - before:
        if each.is_dir():
            shutil.rmtree(each)
        else:
            each.unlink()


def _table(path: str) -> tuple[list[str], list[list[str]]]:
    with Path(path).open(newline="") as stream:
        header, *rows = csv.reader(stream)
    return header, rows


def test_each_sample_of_an_out_port_is_a_row() -> None:
    selected = ["--csv", "PathFollower0.velocity", "--csv", "v.csv"]
    assert run([*SHORT, "-q", *selected]) == 0
    header, rows = _table("v.csv")
    whole = "PathFollower0.velocity.data"
    assert header == [
        "t",
        f"{whole}.vx [m/s]",
        f"{whole}.vy [m/s]",
        f"{whole}.va [rad/s]",
    ]
    assert len(rows) == 500
    assert [row[0] for row in rows[:3]] == ["0.0", "0.001", "0.002"]
    assert float(rows[-1][3]) == pytest.approx(0.3)


def test_a_column_is_selected_by_its_name() -> None:
    whole = "RefHardRh30.OutWheelAngle"
    assert run([*SHORT, "-q", "--csv", whole, "--csv", "whole.csv"]) == 0
    header, rows = _table("whole.csv")
    assert header == ["t", f"{whole}[0] [rad]", f"{whole}[1] [rad]"]
    assert run([*SHORT, "-q", "--csv", f"{whole}[1]", "--csv", "one.csv"]) == 0
    assert _table("one.csv") == (["t", header[2]], [[row[0], row[2]] for row in rows])


def test_members_in_ports_and_observables() -> None:
    selected = [
        "PathFollower0.velocity.data.va",
        "RefHardRh30.InTargetVelocity.data.va",
    ]
    selected += ["RefHardRh30.truth[2]"]
    options = [text for name in selected for text in ("--csv", name)]
    assert run([*SHORT, "-q", *options]) == 0
    header, rows = _table("build/rh3_goal/values.csv")
    units = ["[rad/s]", "[rad/s]", ""]
    titles = [f"{n} {u}".strip() for n, u in zip(selected, units, strict=True)]
    assert header == ["t", *titles]
    columns = list(zip(*rows, strict=True))
    assert len([text for text in columns[1] if text]) == 500
    # The base reads what the follower has written, and is recorded 50 times a second.
    assert {text for text in columns[2] if text} <= set(columns[1])
    assert [row[0] for row in rows if row[3]][:3] == ["0.0", "0.02", "0.04"]


@pytest.mark.sampled(0)
def test_a_picture_has_axes_with_units(capfd: pytest.CaptureFixture[str]) -> None:
    selected = ["--plot", "PathFollower0.velocity", "--plot", "RefHardRh30.truth"]
    assert run([*SHORT, *selected]) == 0
    assert "results: build/rh3_goal/values.svg" in capfd.readouterr().err
    file = Path("build/rh3_goal/values.svg")
    ElementTree.parse(file)
    texts = re.findall(r"<!-- (.*?) -->", file.read_text())
    assert {"[m/s]", "[rad/s]"} <= {*texts}
    assert "simulated time [s]" in texts
    assert "PathFollower0.velocity.data.va" in texts
    first = file.read_bytes()
    assert run([*SHORT, "-q", *selected, "--plot", "again.svg"]) == 0
    assert Path("again.svg").read_bytes() == first


def test_trajectories_are_drawn_as_before() -> None:
    assert run([*SHORT, "-q", "--plot", "t.svg", "--csv", "t.csv"]) == 0
    assert _table("t.csv")[0][:4] == ["t", "x", "y", "theta"]
    assert "x [m]" in Path("t.svg").read_text()


@pytest.mark.parametrize(
    ("arguments", "code", "message"),
    [
        (
            ["--plot", "PathFollower0.velocty"],
            2,
            "did you mean PathFollower0.velocity?",
        ),
        (["--plot", "PathFollowr0.velocity"], 2, "did you mean 'PathFollower0'?"),
        (["--csv", "PathFollowr0.velocity"], 2, "did you mean 'PathFollower0'?"),
        (["--plot", "PathFollower0.velocity.data.vz"], 2, "hint: members: vx, vy, va"),
        (["--csv", "PathFollower0.velocity[0]"], 2, "has no elements"),
        (["--csv", "PositionInput0.status.daat"], 2, "did you mean 'data'?"),
        (
            ["--csv", "RefHardRh30.truth.x"],
            2,
            "an observable has numbers: RefHardRh30.truth[0]",
        ),
        (
            ["--plot", "PathFollower0.velocity.foo"],
            2,
            "has no member 'foo'\n  hint: members: tm, id, data",
        ),
        (
            ["--plot", "RefHardRh30.OutWheelAngle[2]"],
            2,
            "hint: the sequence has 2 elements",
        ),
        (["--plot", "PathFollower0.velocity["], 2, "names no value of a port"),
        (["--csv", "a.csv", "--csv", "b.csv"], 2, "two files, a.csv and b.csv"),
        (["--plot", "a.jpeg"], 3, "unknown kind of picture"),
        (
            ["--plot", "a.svg", "--plot", "PathFollower0.velocty"],
            2,
            "did you mean PathFollower0.velocity?",
        ),
    ],
)
def test_what_is_not_there(
    arguments: list[str], code: int, message: str, capfd: pytest.CaptureFixture[str]
) -> None:
    assert run([*SHORT, *arguments]) == code
    err = capfd.readouterr().err
    assert message in err
    assert ("PathFollower0 ACTIVE" in err) is ("sequence has" in message)
    assert not Path("a.svg").exists()


@pytest.mark.sampled(1)
@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("MPLBACKEND", "typewriter", "the environment variable MPLBACKEND"),
        ("SOURCE_DATE_EPOCH", "today", "matplotlib cannot write a.svg: invalid"),
    ],
)
def test_an_environment_that_matplotlib_rejects(
    name: str, value: str, message: str
) -> None:
    command = [sys.executable, "-m", "rtgen", *SHORT, "-q", "--plot", "a.svg"]
    command += ["--plot", "PathFollower0.velocity"]
    done = subprocess.run(
        command, env={**os.environ, name: value}, capture_output=True, text=True
    )
    assert done.returncode == 3
    assert message in done.stderr
    assert "internal error" not in done.stderr
