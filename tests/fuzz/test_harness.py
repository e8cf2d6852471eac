"""The harness starts as a program, counts inputs and stores those at which a door raises."""

from __future__ import annotations

import json
import logging
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from random import Random

import doors
import harness
import pytest
from doors import Door, door


@pytest.fixture(autouse=True)
def logging_goes_on() -> Iterator[None]:
    """Undo that targets suppress the warnings for bad input, which they do for their process."""
    yield
    logging.disable(logging.NOTSET)


def test_it_starts_as_a_program() -> None:
    command = [sys.executable, harness.__file__, "nowhere"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 2, done.stderr
    assert "there is no door nowhere: idl, " in done.stderr


@pytest.mark.nightly
def test_inputs_in_bulk_go_on_where_they_were_stopped(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(harness, "FOUND", tmp_path)
    (tmp_path / "inputs.json").write_text('{"tdr": 150}')
    lines = list(harness.bulk(["tdr", "emcy"], 200, 600.0))
    assert all(sound for _, sound in lines)
    counts = json.loads((tmp_path / "inputs.json").read_text())
    assert counts == {"tdr": 200, "emcy": 200}
    assert [line.split()[:2] for line, _ in lines] == [["emcy", "200"], ["tdr", "50"]]
    assert list(harness.bulk(["tdr", "emcy"], 200, 600.0)) == []
    ((line, _),) = harness.bulk(["slcan"], 200, 600.0, first=180)
    assert line.split()[:2] == ["slcan", "20"]


@pytest.mark.nightly
def test_packages_of_numbered_inputs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(harness, "FOUND", tmp_path)
    [(line, sound)] = harness.typed("msg", 2, 5)
    name, packages, *_, inputs, _, failures, _ = line.replace(",", "").split()
    assert (name, packages, failures, sound) == ("msg", "2", "0", True), line
    assert int(inputs) >= 2
    assert not list(tmp_path.iterdir())


def test_what_a_door_raises_at_is_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(harness, "FOUND", tmp_path)
    monkeypatch.setitem(doors.MODULES, "breaking", "breaking_door")
    monkeypatch.syspath_prepend(str(tmp_path / "modules"))
    folder = tmp_path / "modules"
    folder.mkdir()
    (folder / "breaking_harness.py").write_text(BREAKING)
    import breaking_harness  # type: ignore[import-not-found]

    monkeypatch.setattr(harness, "DoorTarget", breaking_harness.Target)
    [(line, sound)] = harness.bulk(["breaking"], 30, 600.0)
    assert not sound
    assert "30 inputs" in line
    kept = sorted(path.name for path in (tmp_path / "breaking").iterdir())
    assert kept == ["case-13", "case-13.txt"]
    assert (tmp_path / "breaking/case-13").read_bytes() == b"13"
    text = (tmp_path / "breaking/case-13.txt").read_text()
    assert text.endswith("LookupError: 13\n")


BREAKING = """
class Target:
    def __init__(self, name, folder):
        self.name = name

    def make(self, number):
        return str(number).encode()

    def check(self, number, data):
        if data == b"13":
            raise LookupError("13")
        return ["accepted"]
"""


@pytest.mark.parametrize("name", ["idl", "cdr"])
def test_an_input_is_decided_by_its_number(name: str, tmp_path: Path) -> None:
    targets = []
    for number in "12":
        (tmp_path / number).mkdir()
        targets.append(harness.DoorTarget(name, tmp_path / number))
    one, other = targets
    made = [one.make(number) for number in range(40)]
    assert made == [other.make(number) for number in range(40)]
    assert len(set(made)) > 20
    opened: Door = door(name, tmp_path)
    assert opened.make(Random(3)) == opened.make(Random(3))
