"""FPaletteDevice: the f-palette board, simulated."""

from __future__ import annotations

from collections.abc import Callable

from refnav.io_401 import INPUTS, Board
from refrobots import rtc
from refrobots.components.f_palette_device import FPaletteDeviceBase
from refrobots.fpalette import FPaletteObjects
from rtgen.runtime import RTC_OK, ReturnCode_t
from rtgen.runtime.canopen.description import ObjectNumber


class FPaletteDevice(FPaletteDeviceBase):
    """The simulated board; its additional InPort `voltage` feeds analogue input 1.

    Its observables are `inputs` and `outputs`, the voltages there [V].
    """

    def on_initialize(self) -> ReturnCode_t:
        """Switch the board on."""
        self._board = board = Board(self.objects)
        self._voltage = self.add_in_port("voltage", rtc.TimedDouble)
        self._numbers: dict[str, ObjectNumber] = {}
        with self.bus_lock:
            for name in INPUTS:
                index, subindex = getattr(FPaletteObjects, name).number
                self._numbers[name] = index, subindex
                self.node.on_change(index, subindex, self._is_event(name))
        self.observables["inputs"] = lambda: board.voltages
        self.observables["outputs"] = lambda: board.output_voltages
        return RTC_OK

    def on_deactivated(self, ec_id: int) -> ReturnCode_t:
        """Let the outputs take their error values."""
        self._board.leave()
        return RTC_OK

    def on_aborting(self, ec_id: int) -> ReturnCode_t:
        """Let the outputs take their error values."""
        self._board.leave()
        return RTC_OK

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        """Read the inputs, drive the outputs."""
        if self._voltage.is_new() and (sample := self._voltage.read_newest()):
            self._board.voltages[0] = sample.data
        self._board.step()
        with self.bus_lock:
            for name in self._board.events:
                self.node.trigger(*self._numbers[name])
        return RTC_OK

    def _is_event(self, name: str) -> Callable[[bytes | None, bytes], bool]:
        """Return the filter for a TPDO's events: the board decides, not a change of the value."""
        return lambda before, after: before is None and self._board.tells_first(name)
