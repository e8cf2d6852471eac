"""The calls of ports for each sample, in C if `rtgen-speed` is used."""

from __future__ import annotations

from functools import cache
from types import ModuleType
from typing import Any

_KINDS = {"write": 0, "read": 1, "is_new": 2}


@cache
def module(
    out_port: type[Any], in_port: type[Any], sole_references: int
) -> ModuleType | None:
    """Return `rtgen_speed`, whose methods have taken the place of the ports'; None without it.

    `sole_references` is that number in a function of Python; its own argument and that of
    `getrefcount` count there, and in C only the stack of the caller.
    """
    from rtgen.runtime.marshalling.tables import speed

    chosen = speed()
    if chosen is None:
        return None
    for class_, name, slot, last in (
        (out_port, "write", "_write", "_write"),
        (in_port, "read", "_sole", "_last"),
        (in_port, "is_new", "_unread", "_unread"),
    ):
        function = vars(class_)[name]
        sole = max(sole_references - 1, 0)
        method = chosen.Method(class_, _KINDS[name], function, slot, last, sole)
        setattr(class_, name, method)
    return chosen
