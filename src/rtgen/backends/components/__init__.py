"""Back end for components: base class, configuration, profile, skeleton, factory entries."""

from __future__ import annotations

from rtgen.backends.components.backend import BACKEND

__all__ = ["BACKEND"]
