"""Back end for wiring diagrams: draws a system of components as SVG."""

from __future__ import annotations

from rtgen.compiler.backends.wiring.diagram import (
    ComponentView,
    PortView,
    TimedConnection,
    view_of,
)
from rtgen.compiler.backends.wiring.drawing import render

__all__ = ["ComponentView", "PortView", "TimedConnection", "render", "view_of"]
