"""The base of generated adapters, which convert each sample in the tick that writes it."""

from __future__ import annotations

from abc import abstractmethod
from typing import Any

from rtgen.runtime.errors import EndOfRunError
from rtgen.runtime.return_codes import RTC_OK, ReturnCode_t
from rtgen.runtime.rtc.callbacks import note_exception
from rtgen.runtime.rtc.component import Component


class Adapter(Component):
    """A component that converts the samples of its port `input`, whenever one comes.

    While it is ACTIVE, it converts in the tick, and in the thread, of the writer, so that it adds
    no delay. Ticks of its own are for its life cycle, for samples that have come before, and for
    those that its port fetches. A sample that cannot be converted leads to ERROR at its own next
    tick.
    """

    def __init__(self, instance_name: str | None = None) -> None:
        super().__init__(instance_name)
        self._is_converting = False
        self._has_echo = False
        """Whether a sample has come of the conversion of another one: from a ring of adapters."""
        self._has_failed = False
        self.in_ports["input"].call_on_arrival(self._came)

    @abstractmethod
    def convert(self, sample: Any) -> None:
        """Convert a sample, and write the result."""

    def on_activated(self, ec_id: int) -> ReturnCode_t:
        """Begin again after a failure."""
        self._has_failed = False
        return RTC_OK

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        """Convert what came while it was not ACTIVE, and what the port fetches."""
        source = self.in_ports["input"]
        with self._lock:
            self._is_converting, self._has_echo = True, False
            try:
                while (
                    not self._has_echo
                    and source.is_new()
                    and (sample := source.read()) is not None
                ):
                    self.convert(sample)
            finally:
                self._is_converting = False
        return RTC_OK

    def _came(self) -> None:
        """Convert the oldest sample; one that comes of its own conversion waits for a tick."""
        source = self.in_ports["input"]
        with self._lock:
            self._has_echo = self._is_converting
            if self._has_echo or self._has_failed or not self.is_active:
                return
            sample = source.read() if source.is_new() else None
            if sample is None:
                return
            self._is_converting = True
            try:
                self.convert(sample)
            except EndOfRunError:
                return
            except BaseException as error:
                # The writer is not to blame.
                self._has_failed = True
                note_exception(self, "on_execute", error)
                self._request_failure(self.reason)
            finally:
                self._is_converting = False
