"""Back end for TECS: the files of joins through rtgen's plug-in."""

from __future__ import annotations

from rtgen.backends.tecs.backend import BACKEND

__all__ = ["BACKEND"]
