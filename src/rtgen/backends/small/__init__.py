"""Back end for small boards: types, component bases and a runtime with fixed buffers."""

from __future__ import annotations

from rtgen.backends import DeferredBackend

TARGET = "small"
"""The target that this back end emits for."""

BACKEND = DeferredBackend(
    "small",
    "rtgen.backends.small.backend",
    lambda _, options: options.target == TARGET,
)

__all__ = ["BACKEND", "TARGET"]
