"""Back end for small boards: types, component bases and a runtime with fixed buffers."""

from __future__ import annotations

from rtgen.backends.small.backend import BACKEND

__all__ = ["BACKEND"]
