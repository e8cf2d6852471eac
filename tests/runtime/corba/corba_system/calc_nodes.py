"""The two components of the tests."""

from __future__ import annotations

import time

from calcbot.calc import Adder, Refused, Result
from calcbot.components.caller import CallerBase
from calcbot.components.counter import CounterBase

from rtgen.runtime import RTC_OK, ReturnCode_t, ServiceError


class _Adding(Adder):
    def __init__(self) -> None:
        self._naps = 0

    def add(self, a: int, b: int) -> int:
        if b == 13:
            raise Refused("unlucky", b)
        return a + b

    def nap(self, seconds: float) -> None:
        self._naps += 1
        time.sleep(seconds)

    @property
    def naps(self) -> int:
        return self._naps


class Counter(CounterBase):
    """A component that adds."""

    def on_initialize(self) -> ReturnCode_t:
        self.adder.set_servant(_Adding())
        return RTC_OK


class Caller(CallerBase):
    """A component that calls at every tick, and reports the results."""

    number = 0

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        result = Result(0, "")
        try:
            result.number = self.number = self.adder.object.add(self.number, 1)
        except ServiceError as error:
            result.error = type(error).__name__
        self.results.write(result)
        return RTC_OK
