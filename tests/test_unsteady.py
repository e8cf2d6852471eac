"""Which failures of a run count, by `unsteady.py`."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import pytest
import unsteady

TESTS = """
import pathlib

def turns():
    with open(pathlib.Path(__file__).with_name("turns"), "a+") as file:
        file.write("x")
        return file.tell()

def test_first(): turns()
def test_second(): turns()
def test_third(): turns()
def test_fourth(): turns()
def test_passes_once(): assert turns() != 2
def test_never_passes(): assert not turns()
"""


@pytest.mark.parametrize(
    ("code", "failed", "judgement", "turns"),
    [
        (1, ["first"], 0, 3),
        (1, ["first", "second", "third"], 0, 9),
        (1, ["passes_once"], 1, 2),
        (1, ["never_passes", "first"], 1, 2),
        (1, ["first", "second", "third", "fourth"], 1, 4),
        (2, ["first"], 2, 1),
        (4, [], 4, 0),
    ],
)
def test_tests_that_pass_alone_each_time_are_no_failures(
    tmp_path: Path, code: int, failed: list[str], judgement: int, turns: int
) -> None:
    file = tmp_path / "test_some.py"
    file.write_text(TESTS)
    cache = tmp_path / "cache"
    if failed:
        (cache / "v" / "cache").mkdir(parents=True)
        names = {f"{file}::test_{name}": True for name in failed}
        (cache / "v" / "cache" / "lastfailed").write_text(json.dumps(names))
    assert unsteady.judge(code, cache, sys.executable) == judgement
    taken = tmp_path / "turns"
    assert (taken.stat().st_size if taken.exists() else 0) == turns
