"""Back end of CANopen devices."""

from __future__ import annotations

from rtgen.backends.canopen.backend import BACKEND

__all__ = ["BACKEND"]
