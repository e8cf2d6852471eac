"""A behaviour with a way through on_execute that has no return code."""

from robots.components.drive import DriveBase

from rtgen.runtime import RTC_OK, ReturnCode_t


class Drive(DriveBase):
    """Ends in the middle."""

    turns = 0

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        """Return early, or not at all."""
        self.turns += 1
        if self.turns < 10:
            return RTC_OK

    def on_activated(self, ec_id: int) -> ReturnCode_t:
        """Return without a value."""
        if ec_id:
            return None
        return RTC_OK
