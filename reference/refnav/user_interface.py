"""UserInterface: sends scripted target lists."""

from __future__ import annotations

from refnav.messages import pose_2d
from refnav.target_script import ScriptError, TargetList, parse
from refrobots import iis
from refrobots.components.user_interface import UserInterfaceBase
from rtgen.runtime import RTC_OK, SECOND, ReturnCode_t

_MAX_FILE = 1024 * 1024


class UserInterface(UserInterfaceBase):
    """Sends each list once, at its time."""

    def on_activated(self, ec_id: int) -> ReturnCode_t:
        """Start the script; without one nothing is sent."""
        self._begin = self.now()
        self._waiting: list[TargetList] = []
        name = self.config.script
        if name:
            try:
                with (self.folder / name).open(encoding="utf-8") as stream:
                    self._waiting = [*parse(stream.read(_MAX_FILE), name)]
            except (OSError, UnicodeDecodeError) as error:
                return self.fail(f"script: cannot read {name}: {error}")
            except ScriptError as error:
                return self.fail(f"script: {error}")
        return RTC_OK

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        """Send the target lists that are due."""
        seconds = (self.now() - self._begin) / SECOND
        while self._waiting and self._waiting[0].at <= seconds:
            due = self._waiting.pop(0)
            targets = iis.TimedPose2DSeq(data=[pose_2d(p) for p in due.targets])
            self.stamp(targets)
            self.targets.write(targets)
        return RTC_OK
