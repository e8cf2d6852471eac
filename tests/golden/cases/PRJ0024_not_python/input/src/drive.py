"""Drive."""

from robots.components.drive import DriveBase

from rtgen.runtime import RTC_OK, ReturnCode_t


class Drive(DriveBase):
    def on_execute(self, ec_id: int) -> ReturnCode_t
        return RTC_OK
