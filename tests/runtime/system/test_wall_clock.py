"""The wall clock may be set at any time: nothing that waits or orders reads it."""

from __future__ import annotations

import ast
import os
import time
from collections.abc import Iterator
from pathlib import Path

import can
import pytest
from rtgen_sources import trees

from rtgen.cli.can import replay_command
from rtgen.runtime import RealClock
from rtgen.runtime.timing.steady import steady_utc
from rtgen.ui import stored_tokens

STAMP = "a stamp for other machines"

READERS = {
    "ui/stored_tokens.py _read": "the age of a file",
    "tools/kit/answering.py answered": "the age of files",
    "tools/kit/answers.py _is_valid": "the age of files",
    "runtime/distribution/local_listener.py ServedRun.__init__": "when a run began, for people",
    "runtime/ros2/zenoh.py AttachedService._on_query.respond": STAMP,
    "runtime/ros2/zenoh_topics.py Attachments.next": STAMP,
    "runtime/timing/clocks.py RealClock.__init__": "set once",
    "runtime/timing/steady.py": "set once",
}
"""Readers of the wall clock, each with its reason."""

WALL = {
    *("time.time", "time.time_ns", "time.localtime", "time.gmtime", "time.ctime"),
    *("time.clock_gettime", "time.clock_gettime_ns", "datetime.now", "datetime.today"),
    *("datetime.utcnow", "date.today", "datetime.datetime.now", "datetime.date.today"),
}
CALLS = {name.rpartition(".")[2] for name in WALL}


def readers(node: ast.AST, scope: tuple[str, ...] = ()) -> Iterator[str]:
    """Yield the functions below a node that read the wall clock."""
    for child in ast.iter_child_nodes(node):
        inner = scope
        if isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
            inner = (*scope, child.name)
        if isinstance(child, ast.Attribute) and ast.unparse(child) in WALL:
            yield ".".join(scope)
        if isinstance(child, ast.ImportFrom) and child.module == "time":
            names = (name.name for name in child.names)
            yield from (name for name in names if f"time.{name}" in WALL)
        yield from readers(child, inner)


def test_few_functions_read_the_wall_clock() -> None:
    found = {
        f"{name} {function}".strip()
        for name, tree in trees(rf"\bfrom time import\b|\.(?:{'|'.join(CALLS)})\b")
        if not name.startswith("examples/")
        for function in readers(tree)
    }
    assert found == READERS.keys()


def test_times_do_not_jump_with_the_wall_clock(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = RealClock()
    clock.restart()
    before = clock.now(), clock.elapsed(), steady_utc()
    hours = 5 * 3600 * 10**9
    for step in (-hours, hours):
        now = time.time_ns() + step
        with monkeypatch.context() as patched:
            patched.setattr(time, "time_ns", lambda now=now: now)
            patched.setattr(time, "time", lambda now=now: now / 1e9)
            after = clock.now(), clock.elapsed(), steady_utc()
        passed = [b - a for a, b in zip(before, after, strict=True)]
        assert all(0 <= each < hours for each in passed)


def test_a_recording_with_a_step_back_is_replayed_without_one() -> None:
    stamps = [7200.0, 7201.0, 1.0, 1.5, 1.25, 2.0]
    messages = [can.Message(timestamp=each) for each in stamps]
    faster = replay_command._faster(iter(messages), 2.0)
    assert [each.timestamp for each in faster] == [0.0, 0.5, 0.5, 0.75, 0.75, 1.125]
    assert [each.timestamp for each in messages] == stamps


def test_tokens_from_the_future_are_not_used(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "tokens"
    file.write_text("full read")
    file.chmod(0o600)
    assert stored_tokens._read(file) is not None
    for age in (-3600.0, stored_tokens.MAX_AGE + 60):
        moment = time.time() - age
        os.utime(file, (moment, moment))
        assert stored_tokens._read(file) is None
