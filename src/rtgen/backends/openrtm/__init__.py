"""Back end for OpenRTM-aist-Python: for each component a module that its manager can load."""

from __future__ import annotations

from rtgen.backends.openrtm.backend import BACKEND

__all__ = ["BACKEND"]
