"""Which failures of a run count, by `unsteady.py`."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
import unsteady

PYTEST = """#!/bin/sh
echo "$*" >> "$0.turns"
case "$*" in
*never*) exit 1 ;;
*once*) [ "$(wc -l < "$0.turns")" -ne 2 ] ;;
esac
"""
"""Stands for pytest: `never` fails each time, `once` the second time."""


@pytest.mark.parametrize(
    ("code", "failed", "judgement", "turns"),
    [
        (1, ["first"], 0, 3),
        (1, ["first", "second", "third"], 0, 3),
        (1, ["once"], 1, 2),
        (1, ["first", "never"], 1, 1),
        (1, ["first", "second", "third", "fourth"], 1, 1),
        (2, ["first"], 2, 1),
        (4, [], 4, 0),
        (5, [], 0, 0),
        (5, ["never"], 0, 0),
    ],
)
def test_tests_that_pass_alone_each_time_are_no_failures(
    tmp_path: Path, code: int, failed: list[str], judgement: int, turns: int
) -> None:
    python = tmp_path / "python"
    python.write_text(PYTEST)
    python.chmod(0o755)
    cache = tmp_path / "cache"
    names = [f"tests/test_some.py::{name}" for name in failed]
    if names:
        (cache / "v" / "cache").mkdir(parents=True)
        text = json.dumps(dict.fromkeys(names, True))
        (cache / "v" / "cache" / "lastfailed").write_text(text)
    assert unsteady.judge(code, cache, str(python)) == judgement
    taken = tmp_path / "python.turns"
    lines = taken.read_text().splitlines() if taken.exists() else []
    assert len(lines) == turns
    assert all(line.endswith(" ".join(names)) for line in lines)
