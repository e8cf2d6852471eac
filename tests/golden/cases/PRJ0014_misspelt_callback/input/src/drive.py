"""A behaviour that does nothing."""

from robots.components.drive import DriveBase

from rtgen.runtime import RTC_OK, ReturnCode_t


class Drive(DriveBase):
    """Has two methods that nothing calls."""

    def on_excute(self, ec_id: int) -> ReturnCode_t:
        """Meant as on_execute."""
        return RTC_OK

    def onActivated(self, ec_id: int) -> ReturnCode_t:  # noqa: N802
        """As in OpenRTM."""
        return RTC_OK
