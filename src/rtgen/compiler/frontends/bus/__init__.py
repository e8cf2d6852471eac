"""Bus files (TOML): nodes of a CANopen network, their start-up values, and PDO links."""

from rtgen.compiler.frontends.bus.reader import load

__all__ = ["load"]
