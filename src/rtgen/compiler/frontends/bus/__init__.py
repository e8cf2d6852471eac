"""Bus files (TOML): nodes of a CANopen network, their start-up values, and PDO links."""

from typing import TYPE_CHECKING

from rtgen.compiler.kit.deferred import deferred

if TYPE_CHECKING:
    from rtgen.compiler.frontends.bus.reader import load

__all__ = ["load"]

# Its rules do not need it.
__getattr__ = deferred("rtgen.compiler.frontends.bus.reader", __all__)
