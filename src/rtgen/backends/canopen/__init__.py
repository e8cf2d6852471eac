"""Back end of CANopen devices."""

from __future__ import annotations

from rtgen.backends import DeferredBackend

BACKEND = DeferredBackend(
    "canopen",
    "rtgen.backends.canopen.backend",
    lambda model, _: bool(model.devices or model.buses),
)

__all__ = ["BACKEND"]
