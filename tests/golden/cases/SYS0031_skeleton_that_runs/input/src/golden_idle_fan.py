# Created once by rtgen from idl/fan.idl.
"""The component Fan."""

from rtgen.runtime import RTC_OK, Component, ReturnCode_t


class Fan(Component):
    """The component Fan."""

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        """Called in every cycle while it is active."""
        return RTC_OK
