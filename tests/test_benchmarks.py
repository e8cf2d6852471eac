"""Benchmarks run, with their smallest rounds, and docs/speed.md has their stored results."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest
import ros2_peers
import speed

ROOT = Path(__file__).resolve().parent.parent
FOLDER = ROOT / "benchmarks"
NIGHTLY = (pytest.mark.nightly, pytest.mark.in_turns)
MARKS = {"pdo": (), "realtime": pytest.mark.waits}
"""Marks of those that `make test` starts, too."""
PEERS = {
    "cdr": ("google.protobuf", "cyclonedds", "omniORB"),
    "corba": ("omniORB",),
    "fleet": ("zenoh",),
    "floods": ("zenoh", "omniORB"),
    "idl": ("omniORB",),
    "latency": ("cyclonedds", "zenoh", "omniORB"),
    "openrtm": ("omniORB",),
    "payload": ("cyclonedds", "omniORB"),
    "pdo": ("canopen",),
    "transports": ("cyclonedds", "zenoh", "omniORB"),
    "values": ("omniORB",),
}
"""Modules that benchmarks cannot do without."""
OPTIONS = "Arguments(__doc__"
"""What all benchmarks have, and the programs of their other processes have not."""
SCRIPTS = sorted(p.stem for p in FOLDER.glob("*.py") if OPTIONS in p.read_text("utf-8"))

sys.path.append(str(FOLDER))

import speed_page as page  # noqa: E402
import tables  # noqa: E402


@pytest.mark.sampled(1)
@pytest.mark.peer
@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=MARKS.get(name, NIGHTLY)) for name in SCRIPTS],
)
def test_each_benchmark_runs(name: str) -> None:
    for module in PEERS.get(name, ()):
        pytest.importorskip(module)
    if name == "ros2" and isinstance(missing := ros2_peers.make("jazzy"), str):
        pytest.skip(missing)
    if name == "values":
        speed.module()
    command = [sys.executable, str(FOLDER / f"{name}.py"), "--smallest"]
    done = subprocess.run(
        command, stdout=subprocess.PIPE, text=True, check=False, timeout=600
    )
    assert done.returncode == 0
    titles, *rows = done.stdout.lstrip().splitlines()
    assert titles
    assert rows


def test_benchmarks_have_the_common_options() -> None:
    """Of all scripts that say how they are started, except those that make the page."""
    started = {
        path.stem
        for path in FOLDER.glob("[!_]*.py")
        if f"    python benchmarks/{path.name}" in path.read_text("utf-8")
        and not path.stem.endswith("_ends")
    }
    assert started - {"speed_page"} == {*SCRIPTS}


def test_the_page_has_the_stored_tables() -> None:
    text = page.PAGE.read_text(encoding="utf-8")
    assert page.updated(text, page.stored()) == text, "python benchmarks/speed_page.py"
    names = re.findall(r"<!-- table: ([\w/-]+) -->", text)
    assert sorted(names) == sorted(page.stored())


def test_a_run_replaces_the_tables_that_it_measured(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tables, "RESULTS", tmp_path)
    for run in (("one", "two"), ("two",)):
        chosen = tables.Arguments("", rounds=3).parse_args(
            ["--store", "--rounds", str(len(run))]
        )
        with tables.Results("some.py", chosen) as results:
            for name in run:
                results.table(name, "case", ("time", ".1f"), "limit").add(
                    "a", 1 / 3, None
                )
    found = json.loads((tmp_path / "some.json").read_text("utf-8"))
    assert {name: each["rounds"] for name, each in found.items()} == {
        "one": 2,
        "two": 1,
    }
    assert found["one"]["rows"] == [["a", 1 / 3, None]]
    text = page.updated(
        "<!-- table: some/one -->\nold\n<!-- end of table -->\n", page.stored()
    )
    assert "old" not in text
    assert "| a | 0.3 |  |\n" in text


def add_two_cells(chosen: object) -> None:
    """Add too many cells to a table."""
    with tables.Results("some.py", chosen) as results:
        results.table("one", "case").add("a", "b")


def test_a_failed_run_and_the_smallest_rounds_store_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tables, "RESULTS", tmp_path)
    chosen = tables.Arguments("", rounds=3).parse_args(["--store"])
    with pytest.raises(ValueError, match="1 columns"):
        add_two_cells(chosen)
    with pytest.raises(SystemExit):
        tables.Arguments("", rounds=3).parse_args(["--store", "--smallest"])
    assert not [*tmp_path.iterdir()]
