"""Output of commands cannot control a terminal; output to a file is unchanged."""

from __future__ import annotations

import io
import os
import pty
import sys

import pytest

from rtgen.cli.common import write_out
from rtgen.diagnostics.printable import printable

HOSTILE = "\x1b[2J\x07 a\u202eb \x9b31m\ud800\n\tnext\r"
CLEAN = "\ufffd[2J\ufffd a\ufffdb \ufffd31m\ufffd\n\tnext\ufffd"


def test_on_a_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    control, terminal = pty.openpty()
    with os.fdopen(terminal, "w", encoding="utf-8") as stream:
        monkeypatch.setattr(sys, "stdout", stream)
        write_out(HOSTILE)
        shown = os.read(control, 1000).decode()
    os.close(control)
    # The terminal itself writes a line's end in two characters.
    assert shown.replace("\r\n", "\n") == CLEAN


def test_into_a_file(monkeypatch: pytest.MonkeyPatch) -> None:
    octets = io.BytesIO()
    monkeypatch.setattr(sys, "stdout", io.TextIOWrapper(octets, "ascii"))
    write_out(HOSTILE)
    assert octets.getvalue() == HOSTILE.encode("utf-8", "backslashreplace")


@pytest.mark.parametrize("text", ["速度\u3000[m/s]", "a\u00a0b", "é ü 漢字 🤖", "²℘"])
def test_texts_of_all_languages_stay(text: str) -> None:
    assert printable(text) == text
