"""`rtgen run` of parts of RH3's pipeline, each in a process of its own."""

from __future__ import annotations

import struct
import subprocess
import sys
import time
from collections import deque
from pathlib import Path

from fault_table import bound
from patience import until

from rtgen.runtime.timing.clocks import SECOND

ROOT = Path(__file__).parents[3]
SYSTEM = ROOT / "specs" / "navigation" / "rh3_goal.xml"
ROBOT = "RefHardRh30,Odometry0"
WAY = "PathFollower0,Navigation0"
CONSOLE = "PositionInput0,OmniTo2WD0"
GOAL = (0.5, 0.2, 0.4)
"""x, y [m] and heading [rad]: near, since the run is in real time, and to the side."""
TO_GOAL = [
    option
    for name, value in zip(("x", "y", "th"), GOAL, strict=True)
    for option in ("--set", f"PositionInput0.01_{name}={value}")
]


def leased(folder: Path, seconds: float) -> Path:
    """Return the system with a lease for a connection."""
    first = '<rtsExt:Properties rtsExt:name="dataport.inport.buffer.length"'
    lease = first.replace("inport.buffer.length", "qos.lease")
    text = SYSTEM.read_text(encoding="utf-8")
    file = folder / "leased.xml"
    file.write_text(
        text.replace(first, f'{lease} rtsExt:value="{seconds}"/>{first}', 1),
        encoding="utf-8",
    )
    return file


class Wheels:
    """Commands and motion of the base, by the time stamps of the samples."""

    _STAMP = struct.Struct("<4x2I")

    def __init__(self) -> None:
        self.commanded = 0
        self._angles: deque[tuple[int, bytes]] = deque(maxlen=50_000)

    def on_command(self, octets: bytes) -> None:
        """Record a sample of the velocity."""
        self.commanded = self._stamp(octets)

    def on_angles(self, octets: bytes) -> None:
        """Record a sample of the wheels' angles."""
        self._angles.append((self._stamp(octets), octets[self._STAMP.size :]))

    def _stamp(self, octets: bytes) -> int:
        seconds, nanoseconds = self._STAMP.unpack_from(octets)
        return int(seconds * SECOND + nanoseconds)

    @property
    def turn(self) -> bool:
        """Whether the wheels have turned."""
        return len({angles for _, angles in self._angles.copy()}) > 10

    def after_bound(self) -> list[bytes]:
        """Return the angles after the bound of the last command.

        The first one may still have the turn of a tick that began before the bound.
        """
        end = self.commanded + bound("wheels")
        return [angles for stamp, angles in self._angles.copy() if stamp > end][1:]


class Run:
    """The run of some components, with the options of a transport."""

    def __init__(
        self,
        folder: Path,
        transport: list[str],
        only: str,
        *more: str,
        system: Path = SYSTEM,
    ) -> None:
        self._errors = folder / f"{only}-{time.monotonic_ns()}.txt"
        command = [sys.executable, "-m", "rtgen", "run"]
        command += [str(system), "--clock", "real"]
        command += ["--transport", *transport, "--only", only, *more]
        with self._errors.open("w", encoding="utf-8") as errors:
            self.process = subprocess.Popen(
                command, cwd=ROOT, stdout=subprocess.PIPE, stderr=errors, text=True
            )

    @property
    def errors(self) -> str:
        """Standard error so far."""
        return self._errors.read_text(encoding="utf-8")

    def wait_for(self, text: str) -> None:
        """Wait until standard error has a text."""
        until(
            lambda: text in self.errors or self.process.poll() is not None,
            shown=lambda: self.errors,
        )
        assert text in self.errors, self.errors

    def kill(self) -> None:
        """Kill the process."""
        self.process.kill()
        assert self.process.stdout is not None
        if not self.process.stdout.closed:
            self.process.communicate()
