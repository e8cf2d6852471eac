"""Options of commands that record a run as MCAP."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING

from rtgen import runtime
from rtgen.compiler.diagnostics import ToolError
from rtgen.compiler.systems.rules import MISSING
from rtgen.runtime.system.records import MissingSamples
from rtgen.tools.kit.console import Console
from rtgen.tools.kit.exits import Refusal

if TYPE_CHECKING:
    from rtgen.tools.recording.recorder import Recorder

_MAX_CHUNK_NS = 1_000_000_000
"""Maximum duration of a chunk in real time, in ns."""


@dataclass(frozen=True, slots=True)
class RecordingOptions:
    """Options of a recording: the file and its compression."""

    file: str | None = None
    compression: str | None = None

    def begin(self, files: ExitStack, running: runtime.System) -> Recorder | None:
        """Record a system from now on until `files` is closed; None without a file."""
        if self.file is None:
            if self.compression is not None:
                raise Refusal("--compression goes with --record")
            return None
        from rtgen.tools.recording.errors import RecordingError
        from rtgen.tools.recording.mcap_writer import McapWriter
        from rtgen.tools.recording.recorder import Recorder

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
        from rtgen.tools.recording.errors import RecordingError

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
