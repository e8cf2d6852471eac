"""The component Hand."""

from robots.components.hand import HandBase

from rtgen.runtime import RTC_OK, ReturnCode_t


class Hand(HandBase):
    """Toggles the lamp near it."""

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        """Toggle."""
        self.near.toggle()
        return RTC_OK
