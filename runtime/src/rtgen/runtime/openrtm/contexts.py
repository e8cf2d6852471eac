"""Adapters of OpenRTM's execution contexts for behaviours."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from types import TracebackType
from typing import Any

from rtgen.runtime.return_codes import RTC_OK, ReturnCode_t
from rtgen.runtime.rtc.component import Component
from rtgen.runtime.rtc.execution_context import ExecutionContext
from rtgen.runtime.timing.clocks import RealClock

_POLL_INTERVAL = 0.001


class PollingGuard:
    """A guard without notifications: samples remain in OpenRTM until they are polled."""

    def __init__(self) -> None:
        self._condition = threading.Condition()

    def __enter__(self) -> bool:
        return self._condition.__enter__()

    def __exit__(
        self,
        exc_type: type[BaseException] | None,
        exc_val: BaseException | None,
        exc_tb: TracebackType | None,
        /,
    ) -> None:
        self._condition.__exit__(exc_type, exc_val, exc_tb)

    def notify_all(self) -> None:
        """See `Guard`."""
        self._condition.notify_all()

    def wait_for(
        self, predicate: Callable[[], bool], timeout: float | None = None
    ) -> bool:
        """Poll the predicate every millisecond, for at most `timeout` seconds."""
        end = None if timeout is None else time.monotonic() + timeout
        while not predicate():
            if end is not None and time.monotonic() >= end:
                return False
            self._condition.wait(_POLL_INTERVAL)
        return True


class MachineClock(RealClock):
    """Real time, as in OpenRTM's own time stamps: UTC since 1970."""

    def guard(self) -> PollingGuard:
        return PollingGuard()


class HostContext(ExecutionContext):
    """A context with OpenRTM's ticks; `wake` is called after each request of a behaviour.

    `reference` returns OpenRTM's context.
    """

    def __init__(
        self,
        reference: Callable[[], Any],
        owner: Component | None,
        wake: Callable[[], None],
    ) -> None:
        super().__init__(owner=owner)
        self._reference = reference
        self._wake = wake

    def get_rate(self) -> float:
        """Return the current rate of OpenRTM's context in Hz."""
        return float(self._reference().get_rate())

    def set_rate(self, rate: float) -> ReturnCode_t:
        """Set the rate of OpenRTM's context; see `ExecutionContext`."""
        return ReturnCode_t[str(self._reference().set_rate(float(rate)))]

    def set_running(self, running: bool) -> None:
        """Record that OpenRTM has started or stopped the context."""
        self._running = running

    def activate_component(self, component: Component) -> ReturnCode_t:
        """See `ExecutionContext`."""
        return self._woken(super().activate_component(component))

    def deactivate_component(self, component: Component) -> ReturnCode_t:
        """See `ExecutionContext`."""
        return self._woken(super().deactivate_component(component))

    def reset_component(self, component: Component) -> ReturnCode_t:
        """See `ExecutionContext`."""
        return self._woken(super().reset_component(component))

    def fail_component(self, component: Component, reason: str) -> ReturnCode_t:
        """See `ExecutionContext`."""
        return self._woken(super().fail_component(component, reason))

    def _woken(self, code: ReturnCode_t) -> ReturnCode_t:
        if code is RTC_OK:
            self._wake()
        return code
