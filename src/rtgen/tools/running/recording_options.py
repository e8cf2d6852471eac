"""Options of commands that record a run as MCAP."""

from __future__ import annotations

from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Final

from rtgen import runtime
from rtgen.compiler.systems.rules import MISSING
from rtgen.runtime.system.records import MissingSamples
from rtgen.tools.kit.console import Console
from rtgen.tools.kit.exits import Refusal
from rtgen.tools.recording.mcap_writer import McapWriter, require_library

if TYPE_CHECKING:
    from rtgen.tools.recording.bag_recorder import BagRecorder
    from rtgen.tools.recording.recorder import Recorder

_SUFFIX = ".mcap"
MAX_CHUNK_NS: Final = 1_000_000_000
"""Maximum duration of a chunk in real time, in ns."""


@dataclass(frozen=True, slots=True)
class RecordingOptions:
    """Options of a recording: the file and its compression.

    Raises ToolError if the library is not installed: before a run creates components or files.
    """

    file: str | None = None
    compression: str | None = None

    def __post_init__(self) -> None:
        if self.file is not None:
            require_library()

    @property
    def events_file(self) -> Path:
        """The file of the events of a run with topics, which are a bag of ROS 2 beside it."""
        path = Path(self.file or "")
        if path.suffix.lower() == _SUFFIX:
            return path.with_suffix(f".rtgen{_SUFFIX}")
        return path / f"rtgen{_SUFFIX}"

    def bag(self, files: ExitStack, running: runtime.System) -> BagRecorder | None:
        """Record the topics of a system as a bag until `files` is closed; None without a file.

        Raises ToolError.
        """
        if self.file is None:
            return None
        from rtgen.tools.recording.bag_recorder import BagRecorder
        from rtgen.tools.recording.bag_writer import BagWriter

        compression, longest = self.compression or "zstd", longest_chunk(running)
        writer = files.enter_context(BagWriter(Path(self.file), compression, longest))
        recorder = BagRecorder(running, writer)
        files.callback(recorder.close)
        return recorder

    def begin(
        self,
        files: ExitStack,
        running: runtime.System,
        bag: BagRecorder | None = None,
    ) -> Recorder | None:
        """Record a system from now on until `files` is closed; None without a file.

        With a bag, the file is `events_file`. Raises ToolError.
        """
        if self.file is None:
            if self.compression is not None:
                raise Refusal("--compression goes with --record")
            return None
        from rtgen.tools.recording.recorder import Recorder

        file = self.file if bag is None else self.events_file
        return Recorder(running, self.writer(files, file, longest_chunk(running)))

    def writer(
        self, files: ExitStack, file: str | Path, longest: int | None
    ) -> McapWriter:
        """Return a writer of a file until `files` is closed; `longest` as of `longest_chunk`.

        Raises ToolError.
        """
        compression = self.compression or "zstd"
        return files.enter_context(McapWriter(file, compression, longest=longest))

    def numbered(self, number: int) -> RecordingOptions:
        """Return the options for a further run: `FILE-2.mcap`, `FILE-3.mcap`, ..."""
        if self.file is None or number < 2:
            return self
        path = Path(self.file)
        return replace(
            self, file=str(path.with_name(f"{path.stem}-{number}{path.suffix}"))
        )

    def name_file(self, console: Console) -> None:
        """Say which file was recorded, if there is one."""
        if self.file is not None:
            console.say(f"recorded in {self.file}")

    def tell(self, console: Console, recorder: Recorder | None) -> bool:
        """Report the samples that are missing in the recording; return whether there are some."""
        return recorder is not None and tell_missing(
            console, self.file or "", recorder.missing
        )


def longest_chunk(running: runtime.System) -> int | None:
    """Return the longest time of a chunk [ns]; None for any."""
    simulated = isinstance(running.clock, runtime.SimulatedClock)
    return None if simulated else MAX_CHUNK_NS


def tell_missing(console: Console, file: str, missing: MissingSamples) -> bool:
    """Report the samples that are missing in a file; return whether there are some."""
    console.findings(
        [MISSING.at(None, f"{file}: {message}") for message in missing.messages()]
    )
    return bool(missing)
