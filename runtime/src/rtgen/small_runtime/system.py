# mypy: allow-untyped-defs, allow-incomplete-defs, allow-untyped-calls
"""Components on one clock."""

from .codes import (
    ACTIVATE,
    ACTIVE_STATE,
    CREATED_STATE,
    DEACTIVATE,
    INACTIVE_STATE,
    RESET,
    SECOND,
)
from .components import Component


class System:
    """Components on one clock; at equal times they run in the order in which they were added.

    Those that samples execute run directly after the component that has written them.
    `wait` is called with the nanoseconds until the next tick; without it, time is simulated.
    """

    def __init__(self, wait=None) -> None:
        self.time = 0
        self._wait = wait
        self._components: list[Component] = []
        self._periods: list[int] = []
        self._due: list[int] = []
        self._woken: list[Component] = []

    def add(self, component: Component, rate: "float | None" = None) -> None:
        """Add a component at a rate [Hz], by default its own. Raises ValueError."""
        hertz = component._rate if rate is None else rate
        if not 0.0 < hertz <= SECOND:
            raise ValueError("the rate must be a number of Hz above 0")
        component._now = self.time
        if not component._call("on_initialize"):
            raise ValueError(component.instance_name + ": " + component.reason)
        component._state = INACTIVE_STATE
        component._call("on_startup", 0)
        if component._triggers is not None:
            component._wake = lambda: self._wake(component)
            for port in component._trigger_ports():
                port._arrived = component._wake
        self._components.append(component)
        self._periods.append(round(SECOND / hertz))
        self._due.append(self.time)

    def configure(self, component: Component, name: str, text: str) -> None:
        """Set a parameter by its Python name. Raises ValueError."""
        component._configure(name, text)

    def state(self, component: Component) -> int:
        """Return the state of a component."""
        return component._state

    def ticks(self, component: Component) -> int:
        """Return how often `on_execute` was called."""
        return component._ticks

    def activate(self, component: Component) -> int:
        """Request ACTIVE."""
        return component._request(ACTIVATE)

    def deactivate(self, component: Component) -> int:
        """Request INACTIVE."""
        return component._request(DEACTIVATE)

    def reset(self, component: Component) -> int:
        """Request INACTIVE after an error."""
        return component._request(RESET)

    def run(self, until: int) -> None:
        """Run until a time [ns since the start], exclusive."""
        due = self._due
        while due and min(due) < until:
            instant = min(due)
            if self._wait is not None:
                self._wait(instant - self.time)
            self.time = instant
            for i in range(len(due)):
                if due[i] == instant:
                    due[i] = instant + self._periods[i]
                    self._components[i]._cycle(instant)
                    while self._woken:
                        woken = self._woken.pop(0)
                        if woken._take_samples(instant):
                            self._wake(woken)
        self.time = until

    def _wake(self, component: Component) -> None:
        if component not in self._woken:
            self._woken.append(component)

    def close(self) -> None:
        """Finalize all components, the one added last first, deactivating them if necessary."""
        while self._components:
            component = self._components.pop()
            self._periods.pop()
            self._due.pop()
            if component._state == ACTIVE_STATE:
                component._carry_out(DEACTIVATE)
            component._call("on_shutdown", 0)
            component._call("on_finalize")
            component._state = CREATED_STATE
