"""TECS: codecs and what else one `through` of our plug-in asks for."""

from __future__ import annotations

from rtgen.backends.tecs.backend import BACKEND

__all__ = ["BACKEND"]
