"""The soak tests detect growth and loss; small shares of them run here."""

import gc
import importlib.util
import mmap
import os
import re
import sys
import threading
from collections.abc import Iterator

import pytest
import soak

Steps = Iterator[tuple[int, tuple[int, ...]]]
COUNT = 5000


@pytest.fixture(autouse=True)
def few_samples(monkeypatch: pytest.MonkeyPatch) -> None:
    """Take eight samples, with garbage collections that exclude objects of earlier tests."""
    monkeypatch.setattr(soak, "SAMPLES", 8)
    gc.collect()
    gc.freeze()


def running(monkeypatch: pytest.MonkeyPatch, steps: object) -> tuple[str, bool]:
    monkeypatch.setitem(soak.PARTS, "calls", steps)  # type: ignore[arg-type]
    return soak.soak("calls", COUNT / soak.FULL["calls"])


def test_some_calls() -> None:
    line, _ = soak.soak("calls", 2000 / soak.FULL["calls"])
    # With so few calls, the memory is not significant.
    found = re.search(r"descriptors \d+ ([+-]\d+), threads \d+ ([+-]\d+)$", line)
    assert found is not None, line
    assert all(int(growth) <= 0 for growth in found.groups()), line


def test_some_seconds() -> None:
    line, _ = soak.soak("rh3", 20 / soak.FULL["rh3"])
    assert line.startswith("rh3 ")


def test_memory_that_grows(monkeypatch: pytest.MonkeyPatch) -> None:
    # Fresh pages: the heap may have room for objects.
    size = 4 * mmap.PAGESIZE
    with mmap.mmap(-1, (COUNT + 1) * size) as pages:

        def steps(count: int) -> Steps:
            for number in range(1, count + 1):
                pages[number * size : (number + 1) * size] = b"x" * size
                yield number, (os.getpid(),)

        line, flat = running(monkeypatch, steps)
    assert not flat, line


def test_descriptors_and_threads_that_grow(monkeypatch: pytest.MonkeyPatch) -> None:
    kept: list[int] = []
    waiting: list[threading.Thread] = []
    end = threading.Event()

    def opening(count: int) -> Steps:
        for number in range(1, count + 1):
            if number % 100 == 0:
                kept.append(os.open(os.devnull, os.O_RDONLY))
            yield number, (os.getpid(),)

    def starting(count: int) -> Steps:
        for number in range(1, count + 1):
            if number % 100 == 0:
                waiting.append(threading.Thread(target=end.wait))
                waiting[-1].start()
            yield number, (os.getpid(),)

    try:
        for steps in (opening, starting):
            line, flat = running(monkeypatch, steps)
            assert not flat, line
    finally:
        end.set()
        for thread in waiting:
            thread.join()
        for descriptor in kept:
            os.close(descriptor)


def test_what_is_lost(monkeypatch: pytest.MonkeyPatch) -> None:
    def steps(count: int) -> Steps:
        for number in range(1, count + 1):
            if number == count // 2:
                raise soak.WrongError("call 3 came where 2 was next")
            yield number, (os.getpid(),)

    line, flat = running(monkeypatch, steps)
    assert not flat
    assert "call 3 came where 2 was next" in line


def test_openrtm_is_left_out_where_it_is_not_installed(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    monkeypatch.setattr(sys, "argv", ["soak.py", "openrtm"])
    assert soak.main() == 0
    assert "OpenRTM-aist-Python is not installed" in capsys.readouterr().out


def test_what_cannot_begin(monkeypatch: pytest.MonkeyPatch) -> None:
    def steps(count: int) -> Steps:
        yield from ()
        raise soak.WrongError("start.sh: no port")

    line, flat = running(monkeypatch, steps)
    assert not flat
    assert line.endswith("; start.sh: no port")
