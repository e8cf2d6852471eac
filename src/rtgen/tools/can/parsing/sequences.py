"""Reads sequences of frames: a text file with a frame and its time in each line."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from rtgen.compiler.diagnostics import ToolError
from rtgen.facts.encodings import decode
from rtgen.facts.files import UnreadableError, read_file
from rtgen.runtime.canopen.wire.frames import Frame
from rtgen.tools.can.decoding.node_index import NodeIndex
from rtgen.tools.can.parsing.frames import frame_of_text
from rtgen.tools.kit.exits import Refusal

_LINE = re.compile(r"(?:(?P<plus>\+?)(?P<time>\d+(?:\.\d*)?)\s+)?(?P<frame>.+)")


@dataclass(frozen=True, slots=True)
class Step:
    """A frame that is due `at` seconds after the start."""

    at: float
    frame: Frame


def read_sequence(path: Path, node_index: NodeIndex) -> list[Step]:
    """Read the steps of a file. Raises Refusal with the line, ToolError if it is unreadable.

    A line is `[TIME] FRAME`: the time in seconds since the start or, with `+`, since the line
    before; without a time the frame follows immediately. Lines that begin with `#` are comments.
    """
    try:
        text = decode(read_file(path), standard=True).normal
    except UnreadableError as error:
        raise ToolError(f"cannot read {path}: {error}") from error
    steps = list(_steps(path, text, node_index))
    if not steps:
        raise Refusal(f"{path}: there is no frame in this file")
    return steps


def _steps(path: Path, text: str, node_index: NodeIndex) -> Iterator[Step]:
    at = 0.0
    for number, line in enumerate(text.split("\n"), 1):
        written = line.strip()
        if not written or written.startswith("#"):
            continue
        match = _LINE.fullmatch(written)
        assert match is not None
        if match["time"] is not None:
            time = float(match["time"])
            due = at + time if match["plus"] else time
            if due < at:
                raise Refusal(
                    f"{path}:{number}: {time:g} s is before the line above ({at:g} s)"
                )
            at = due
        try:
            yield Step(at, frame_of_text(match["frame"], node_index))
        except Refusal as error:
            raise Refusal(f"{path}:{number}: {error}") from error
