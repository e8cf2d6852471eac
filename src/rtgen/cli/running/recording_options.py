"""Options of commands that record a run as MCAP."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import click

from rtgen import runtime
from rtgen.cli.common import Console, Refusal
from rtgen.diagnostics import ToolError
from rtgen.runtime.system.records import MissingSamples
from rtgen.systems.rules import MISSING

if TYPE_CHECKING:
    from rtgen.recording.recorder import Recorder

_MAX_CHUNK_NS = 1_000_000_000
"""Maximum duration of a chunk in real time, in ns."""


@dataclass(frozen=True, slots=True)
class RecordingOptions:
    """Options of a recording: the file and its compression."""

    file: str | None
    compression: str | None

    def begin(self, files: ExitStack, running: runtime.System) -> Recorder | None:
        """Record a system from now on until `files` is closed; None without a file."""
        if self.file is None:
            if self.compression is not None:
                raise Refusal("--compression goes with --record")
            return None
        from rtgen.recording.errors import RecordingError
        from rtgen.recording.mcap_writer import McapWriter
        from rtgen.recording.recorder import Recorder

        simulated = isinstance(running.clock, runtime.SimulatedClock)
        try:
            writer = McapWriter(
                self.file,
                self.compression or "zstd",
                longest=None if simulated else _MAX_CHUNK_NS,
            )
        except RecordingError as error:
            raise ToolError(str(error), hint=error.hint) from error
        return Recorder(running, files.enter_context(writer))

    @contextmanager
    def reported(self) -> Iterator[None]:
        """Turn failures of the recording into ToolError."""
        if self.file is None:
            yield
            return
        from rtgen.recording.errors import RecordingError

        try:
            yield
        except RecordingError as error:
            raise ToolError(str(error), hint=error.hint) from error

    def tell(self, console: Console, recorder: Recorder | None) -> bool:
        """Report the samples that are missing in the recording; return whether there are some."""
        return recorder is not None and tell_missing(
            console, self.file or "", recorder.missing
        )


def tell_missing(console: Console, file: str, missing: MissingSamples) -> bool:
    """Report the samples that are missing in a file; return whether there are some."""
    console.findings(
        [MISSING.at(None, f"{file}: {message}") for message in missing.messages()]
    )
    return bool(missing)


def with_recording(command: Callable[..., int]) -> Callable[..., int]:
    """Add the options to a command; the function gets them as `recording`."""

    @click.option(
        "--record",
        "recorded",
        metavar="FILE.mcap",
        help="Record samples, states, parameters, frames and calls of boards as MCAP.",
    )
    @click.option(
        "--compression",
        type=click.Choice(["zstd", "lz4", "none"]),
        help="Compression of --record; default: zstd.",
    )
    @functools.wraps(command)
    def wrapped(
        *args: Any, recorded: str | None, compression: str | None, **kwargs: Any
    ) -> int:
        options = RecordingOptions(recorded, compression)
        return command(*args, recording=options, **kwargs)

    function: Callable[..., int] = wrapped
    return function
