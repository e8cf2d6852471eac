"""PositionInput: reads goals and paths of an operator, and sends them one after the other."""

from __future__ import annotations

import sys
from collections import deque
from typing import TextIO

from refnav.commands import SYNTAX, Command, CommandError, parse, parse_all
from refnav.console import ConsoleReader
from refnav.geometry import Pose
from refnav.messages import pose_message
from refrobots import iis
from refrobots.components.position_input import PositionInputBase
from rtgen.runtime import PORT_OK, RTC_OK, ReturnCode_t

PROMPT = f"{SYNTAX}, 'path' for the set path; end of input when done"

ALL_DONE = "all commands are carried out"


class PositionInput(PositionInputBase):
    """Sends the next command when the previous one has led to FINISH.

    Its observable `goal` is the end of the current command (x, y, theta) [m, rad].
    """

    defined_path = Command(
        (Pose(2.0, 0.0, 0.0), Pose(2.0, 2.0, 0.0), Pose(0.0, 2.0, 3.14))
    )
    """The path of the command `path` without waypoints, on the console."""

    def on_initialize(self) -> ReturnCode_t:
        """Publish the goal, which is empty at first."""
        self.console: TextIO = sys.stdin
        self.console_reader: ConsoleReader | None = None
        self._goal: tuple[float, ...] = ()
        self._unsent: deque[iis.TimedPose2D] = deque()
        self.observables["goal"] = lambda: self._goal
        return RTC_OK

    def on_activated(self, ec_id: int) -> ReturnCode_t:
        """Open the input."""
        self._commands: deque[Command] = deque()
        self._unsent.clear()
        self._sent = False
        match self.config.input:
            case "parameters":
                config = self.config
                goal = Pose(config.goal_x, config.goal_y, config.goal_theta)
                self._commands.append(Command((goal,)))
            case "file":
                file = self.folder / self.config.input_file
                try:
                    text = file.read_text(encoding="utf-8")
                    self._commands.extend(parse_all(text, self.config.input_file))
                except (OSError, UnicodeDecodeError) as error:
                    return self.fail(f"input_file: {error}")
                except CommandError as error:
                    return self.fail(str(error))
            case _:
                self.console_reader = ConsoleReader(self.console)
                _print(PROMPT)
        return RTC_OK

    def on_deactivated(self, ec_id: int) -> ReturnCode_t:
        """Close the input."""
        self._close()
        return RTC_OK

    def on_aborting(self, ec_id: int) -> ReturnCode_t:
        """Close the input."""
        self._close()
        return RTC_OK

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        """Send the rest of a command, wait for its FINISH, then take the next one."""
        if self._unsent:
            self._send()
            return RTC_OK
        finished = self._finished()
        if self._sent and not finished:
            return RTC_OK
        self._sent = False
        command = self._next()
        if command is not None:
            self._goal = command.goal
            self._unsent.extend(_messages(command))
            self._send()
        elif self.console_reader is None:
            return self.fail(ALL_DONE)
        elif self.console_reader.ended:
            if failure := self.console_reader.failure:
                raise OSError(f"console: {failure}")  # not the end of its work
            return self.fail(ALL_DONE)
        return RTC_OK

    def _send(self) -> None:
        # A command rejected by the planner's buffer is sent again in the next execution.
        while self._unsent and self.positon.write(self._unsent[0]) is PORT_OK:
            self._unsent.popleft()
        self._sent = True

    def _finished(self) -> bool:
        finished = False
        while self.status.is_new() and (state := self.status.read()) is not None:
            finished = finished or state.data == iis.State.FINISH
        return finished

    def _next(self) -> Command | None:
        if self.console_reader is None:
            return self._commands.popleft() if self._commands else None
        while (line := self.console_reader.take()) is not None:
            try:
                command = self.defined_path if line.split() == ["path"] else parse(line)
            except CommandError as error:
                _print(str(error))
                continue
            if command is not None:
                return command
        return None

    def _close(self) -> None:
        self._unsent.clear()
        if self.console_reader is not None:
            self.console_reader.close()
            self.console_reader = None


def _messages(command: Command) -> list[iis.TimedPose2D]:
    """Return the messages for a goal (`id` empty) or for a path (`id` is the waypoint's place)."""
    points = command.points
    places: list[list[int]] = [[]]
    if len(points) > 1:
        between = [[iis.PATH_MIDDLE] for _ in points[1:-1]]
        places = [[iis.PATH_FIRST], *between, [iis.PATH_LAST]]
    return [
        iis.TimedPose2D(id=place, data=pose_message(point))
        for place, point in zip(places, points, strict=True)
    ]


def _print(text: str) -> None:
    # Standard output is for the report of a run.
    print(text, file=sys.stderr)
