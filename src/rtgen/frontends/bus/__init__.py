"""Bus files (TOML): the nodes of a CANopen network, what is written to them, and PDO links."""

from rtgen.frontends.bus.reader import load

__all__ = ["load"]
