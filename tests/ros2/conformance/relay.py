"""Sends each message that comes on `in_TYPE` on `out_TYPE`."""

from __future__ import annotations

from subject.components.relay import RelayBase

from rtgen.runtime import RTC_OK, ReturnCode_t


class Relay(RelayBase):
    """Sends each message that comes on `in_TYPE` on `out_TYPE`."""

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        """All that has come goes."""
        for name, port in self.in_ports.items():
            while port.is_new():
                self.out_ports[f"out_{name.removeprefix('in_')}"].write(port.read())
        return RTC_OK
