"""Turns unsolicited changes of a node into requests to its proxy (figure 110)."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

import msgspec

from rtgen.runtime.canopen.master.proxied_node import ProxiedNode
from rtgen.runtime.canopen.wire.emergency import Emergency, EmergencyPolicy
from rtgen.runtime.canopen.wire.nmt import NmtState
from rtgen.runtime.return_codes import (
    ACTIVE_STATE,
    INACTIVE_STATE,
    LifeCycleState,
)
from rtgen.runtime.rtc.component import Component

_MAX_REPORTED: Final = 16
"""Maximum number of reported codes until errors are cleared, or the node boots."""


class StateMirror(msgspec.Struct, eq=False):
    """The watcher of a proxy's node; it never blocks, because the link's lock is held.

    `busy` is True while a transition of the proxy is in progress, which checks the states itself;
    `timeout` implements `Watcher`, `now` is the link's time. `policy` decides which emergency
    messages stop the proxy; the others go to `report`, each code once until errors are cleared.
    Every heartbeat, not only the first of a kind, is compared with the component's state, so that
    the two cannot remain in different states after a race.
    """

    _component: Component
    _busy: Callable[[], bool]
    _timeout: Callable[[], int]
    _now: Callable[[], int]
    _policy: EmergencyPolicy
    _report: Callable[[str], None]
    _reported: set[int] = set()

    def timeout(self) -> int:
        """See `Watcher`."""
        return self._timeout()

    def received(self) -> None:
        """See `Watcher`."""
        for context in tuple(self._component._contexts.values()):
            context.wake()

    def malformed(self, number: int, octets: int, expected: int) -> None:
        """See `Watcher`."""
        effect = "it is ignored" if octets < expected else f"only {expected} are used"
        self._report(f"tpdo{number} has {octets} octets, not {expected}: {effect}")

    def unusable(self, number: int, why: str) -> None:
        """See `Watcher`."""
        self._report(f"tpdo{number}: {why}: it is ignored")

    def booted(self, node: ProxiedNode) -> None:
        """See `Watcher`."""
        self._reported.clear()
        if self._state() is ACTIVE_STATE:
            self._fail(node, "booted while it was operational")

    def beat(self, node: ProxiedNode, state: NmtState) -> None:
        """See `Watcher`."""
        mine = self._state()
        component = self._component
        if state is NmtState.STOPPED:
            self._fail(node, "was stopped")
        elif self._busy():
            return
        elif state is NmtState.OPERATIONAL and mine is INACTIVE_STATE:
            node.listen(self._now())
            for context in tuple(component._contexts.values()):
                context.activate_component(component)
        elif state is NmtState.PRE_OPERATIONAL and mine is ACTIVE_STATE:
            for context in tuple(component._contexts.values()):
                context.deactivate_component(component)

    def lost(self, node: ProxiedNode) -> None:
        """See `Watcher`."""
        milliseconds = node.timeout // 1_000_000
        sign = "answer to node guarding" if node.guarded else "heartbeat"
        self._fail(node, f"is lost: no {sign} for {milliseconds} ms")

    def clashed(self, node: ProxiedNode) -> None:
        """See `Watcher`."""
        self._fail(
            node, "reports states that contradict each other: are there two of them?"
        )

    def on_emergency(self, node: ProxiedNode, emergency: Emergency) -> None:
        """See `Watcher`."""
        if emergency.cleared:
            self._reported.clear()
        elif self._policy.stops(emergency):
            self._fail(node, f"reports EMCY {emergency}")
        elif (
            emergency.code not in self._reported and len(self._reported) < _MAX_REPORTED
        ):
            self._reported.add(emergency.code)
            self._report(f"node {node.node_id} reports EMCY {emergency}")

    def cut_off(self, node: ProxiedNode) -> None:
        """See `Watcher`."""
        self._fail(node, "cannot be reached: the bus is gone")

    def _state(self) -> LifeCycleState | None:
        """Return the component's state, None without a context."""
        for context in tuple(self._component._contexts.values()):
            return context.get_component_state(self._component)
        return None

    def _fail(self, node: ProxiedNode, what: str) -> None:
        self._component._request_failure(f"node {node.node_id} {what}")
