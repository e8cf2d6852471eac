"""The console is read in a thread beside the control loop."""

from __future__ import annotations

import io
import os

import pytest
from patience import until

from refnav import console
from refnav.console import ConsoleReader


def test_lines_of_a_pipe_come_one_by_one_and_the_end_is_seen() -> None:
    read, write = os.pipe()
    with os.fdopen(read, encoding="utf-8") as stream:
        reader = ConsoleReader(stream)
        assert reader.take() is None
        assert not reader.ended
        for part in (b"goal 1 ", b"2 3\r\npa", b"th\nlast \xc3", b"\xa4"):
            os.write(write, part)
        os.close(write)
        reader.wait_for_end()
        assert not reader.ended
        assert [reader.take(), reader.take(), reader.take(), reader.take()] == [
            "goal 1 2 3\r",
            "path",
            "last ä",
            None,
        ]
        assert reader.ended
        reader.close()


def test_closing_ends_the_thread_while_nobody_types() -> None:
    read, write = os.pipe()
    with os.fdopen(read, encoding="utf-8") as stream:
        reader = ConsoleReader(stream)
        reader.close()
        assert reader.ended
    os.close(write)


def test_where_pipes_cannot_be_waited_for_closing_does_not_wait_either(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(console, "WAITS", False)
    read, write = os.pipe()
    stream = os.fdopen(read, encoding="utf-8")
    reader = ConsoleReader(stream)
    os.write(write, b"path\n")
    until(lambda: reader.take() == "path")
    reader.close()
    assert not reader.ended
    os.close(write)
    reader.wait_for_end()
    stream.close()


def test_a_stream_in_memory_is_read_to_its_end() -> None:
    reader = ConsoleReader(io.StringIO("one\ntwo"))
    reader.wait_for_end()
    assert [reader.take(), reader.take(), reader.take()] == ["one", "two", None]
    reader.close()


def test_a_stream_that_fails_ends_with_a_reason() -> None:
    stream = io.StringIO("goal 1 2 3\n")
    stream.close()
    reader = ConsoleReader(stream)
    reader.wait_for_end()
    assert reader.ended
    assert "closed file" in reader.failure
    reader.close()
