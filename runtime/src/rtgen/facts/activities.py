"""The activities of components, as OpenRTM and RTC.xml write them."""

from __future__ import annotations

from typing import Final

EVENT_DRIVEN: Final = "EVENTDRIVEN"
"""The activity of components that samples execute."""
ACTIVITIES: Final = ("PERIODIC", "SPORADIC", EVENT_DRIVEN)


def kind_of_context(activity: str) -> str:
    """Return the kind of a component's own execution context (OMG RTC 1.0, `ExecutionKind`)."""
    return "EVENT_DRIVEN" if activity == EVENT_DRIVEN else "PERIODIC"
