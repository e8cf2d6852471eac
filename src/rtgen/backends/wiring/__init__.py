"""Back end for wiring diagrams: draws a system of components as SVG."""

from __future__ import annotations

from rtgen.backends.wiring.diagram import (
    ComponentView,
    PortView,
    TimedConnection,
    view_of,
)
from rtgen.backends.wiring.drawing import render

__all__ = ["ComponentView", "PortView", "TimedConnection", "render", "view_of"]
