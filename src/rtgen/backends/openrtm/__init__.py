"""Back end for OpenRTM-aist-Python: a module for its manager for each component."""

from __future__ import annotations

from rtgen.backends import DeferredBackend

TARGET = "openrtm"
"""The target that this back end emits for."""

BACKEND = DeferredBackend(
    "openrtm",
    "rtgen.backends.openrtm.backend",
    lambda _, options: options.target == TARGET,
)

__all__ = ["BACKEND", "TARGET"]
