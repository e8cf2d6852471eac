"""Output of commands cannot control a terminal; output to a file is unchanged."""

from __future__ import annotations

import io
import os
import pty
import re
import select
import sys
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager

import pytest

from rtgen.compiler.diagnostics.printable import printable
from rtgen.tools.kit.console import Console, for_output, write_out
from rtgen.tools.running.failures import traceback_text
from rtgen.tools.running.progress import progress

PATIENCE = 10.0
"""Time within which a terminal shows what was written to it [s]."""
HOSTILE = "\x1b[2J\x07 a\u202eb \x9b31m\ud800\n\tnext\r"
CLEAN = "\ufffd[2J\ufffd a\ufffdb \ufffd31m\ufffd\n\tnext\ufffd"


@contextmanager
def terminal_as(stream: str, monkeypatch: pytest.MonkeyPatch) -> Iterator[int]:
    """Replace a stream of `sys` by a terminal; yield what reads from it."""
    control, terminal = pty.openpty()
    with os.fdopen(terminal, "w", encoding="utf-8") as replaced:
        monkeypatch.setattr(sys, stream, replaced)
        yield control
    os.close(control)


def shown_on(control: int, end: str) -> str:
    """Return what a terminal shows up to a text, which may come in several pieces."""
    octets = b""
    deadline = time.monotonic() + PATIENCE
    while end.encode() not in octets and time.monotonic() < deadline:
        if select.select([control], [], [], 0.1)[0]:
            octets += os.read(control, 10_000)
    return octets.decode()


def test_on_a_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    with terminal_as("stdout", monkeypatch) as control:
        assert for_output(HOSTILE) == CLEAN
        write_out(HOSTILE)
        shown = shown_on(control, "next\ufffd")
    # The terminal itself writes a line's end in two characters.
    assert shown.replace("\r\n", "\n") == CLEAN


def test_the_bar_of_a_run(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setenv("COLUMNS", "150")
    with terminal_as("stderr", monkeypatch) as control:
        with ExitStack() as files:
            progress(files, None, quiet=False).state(0, "A[/b]0", f"ERROR {HOSTILE}")
        text = "A[/b]0 ERROR \ufffd[2J\ufffd a\ufffdb \ufffd31m"
        shown = shown_on(control, text)
    assert text in shown
    # Older encodings of terminals have no characters of Braille.
    assert not re.search("[\u2800-\u28ff]", shown)


def test_messages_and_tracebacks(capsys: pytest.CaptureFixture[str]) -> None:
    Console("text", colour=False, quiet=False).say(HOSTILE)
    assert capsys.readouterr().err == f"{CLEAN}\n"
    assert CLEAN in traceback_text(ValueError(HOSTILE), "full")


def test_into_a_file(monkeypatch: pytest.MonkeyPatch) -> None:
    octets = io.BytesIO()
    monkeypatch.setattr(sys, "stdout", io.TextIOWrapper(octets, "ascii"))
    write_out(HOSTILE)
    assert octets.getvalue() == HOSTILE.encode("utf-8", "backslashreplace")


@pytest.mark.parametrize("text", ["速度\u3000[m/s]", "a\u00a0b", "é ü 漢字 🤖", "²℘"])
def test_texts_of_all_languages_stay(text: str) -> None:
    assert printable(text) == text


@pytest.mark.parametrize(
    ("text", "lines"),
    [
        (
            "作成: definitions/drive.eds, tests/test_drive.py",
            ["作成: definitions/drive.eds,", "  tests/test_drive.py"],
        ),
        (
            "書き込み 8、削除 0、同じ 4。作成: src/swing.py",
            ["書き込み 8、削除 0、同じ 4。", "  作成: src/swing.py"],
        ),
        (
            "instance  state  cycles  overruns  lost",
            ["instance  state  cycles  overruns  lost"],
        ),
        (
            "    7 | double wanted; double allowed; ",
            ["    7 | double wanted; double allowed; "],
        ),
    ],
)
def test_messages_fit_a_terminal(
    monkeypatch: pytest.MonkeyPatch, text: str, lines: list[str]
) -> None:
    """Between words, or characters that are two columns wide; tables and excerpts stay."""
    monkeypatch.setenv("COLUMNS", "30")
    with terminal_as("stderr", monkeypatch) as control:
        Console("text", colour=False, quiet=False).say(f"{text}\n.")
        shown = shown_on(control, ".\r\n")
    assert shown.split("\r\n") == [*lines, ".", ""]
