"""What a session tells its pages again and again."""

from __future__ import annotations

from time import monotonic
from typing import TYPE_CHECKING, Final

from rtgen.ui import description
from rtgen.ui.outbox import MAX_SAMPLES
from rtgen.ui.protocol import ui

if TYPE_CHECKING:
    from rtgen.ui.compared_run import ComparedRun
    from rtgen.ui.session_view import SessionView

_FLOWS_INTERVAL: Final = 1.0
"""Time between two counts of the samples on connections [s]."""


class Reports:
    """The time, events of the compared run, and changed statistics of a run."""

    def __init__(self, session: SessionView) -> None:
        self._session = session
        self._counts: dict[str, ui.Statistics] = {}
        self._next_flows = 0.0

    def forget(self, instance: str) -> None:
        """Forget a removed component."""
        self._counts.pop(instance, None)

    def send(self) -> None:
        """Publish what has changed."""
        session, beside = self._session, self._session.beside.run
        has_more_beside = beside is not None and self._of_run_beside(beside)
        if not session.pages:
            return
        if session.runner.playing or has_more_beside:
            session.publish(ui.Event.of_clock(session.time()))
        changed = self._changed_statistics()
        session.history.statistics(session.now, changed)
        self._flows()
        for page in session.pages:
            if changed:
                page.statistics(changed)
            if page.missed_changes:
                page.put(ui.Event.of_whole(session.whole()))

    def _changed_statistics(self) -> list[ui.Statistics]:
        session, changed = self._session, []
        for each in (
            *description.statistics(session.system, session.system.instances),
            *session.remote.statistics.values(),
        ):
            before = self._counts.get(each.instance)
            if each != before:
                self._counts[each.instance] = each
                changed.append(each)
                if before is not None and each.overruns > before.overruns:
                    count = each.overruns - before.overruns
                    session.notice("overrun", each.instance, f"{count} more")
        return changed

    def _flows(self) -> None:
        """Count the samples on connections, if it is time for that."""
        now = monotonic()
        if now < self._next_flows:
            return
        self._next_flows = now + _FLOWS_INTERVAL
        session = self._session
        if session.flows.changed(
            session.now, session.connectors, session.channels.source
        ):
            session.pages.put_in_all(ui.Event.of_flows(session.flows.latest))
        if session.chains.changed():
            session.pages.put_in_all(ui.Event.of_chains(session.chains.latest))

    def _of_run_beside(self, run: ComparedRun) -> bool:
        """Publish what has happened in the compared run; return whether there are samples."""
        session = self._session
        events, samples = run.until(session.now)
        for event in events:
            session.history.add(event.other.time, event)
        session.pages.put(session.types.nodes, events)
        if len(samples) <= MAX_SAMPLES:
            for sample in samples:
                session.sample(sample)
            return bool(samples)
        # After a leap in time, a page gets samples of the whole run, not only the newest.
        for sample in samples:
            session.history.sample(sample)
        for page in session.pages:
            channels = page.watched.intersection(e.id for e in session.beside.channels)
            page.show_samples(session.history.samples(session.now, channels), channels)
        return True
