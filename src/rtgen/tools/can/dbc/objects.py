"""Objects of nodes as signals: types, factors, units, names of values."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from rtgen.facts.canopen import KIND_BITS, SIGNED_KINDS
from rtgen.tools.can.dbc.database import Signal
from rtgen.tools.can.decoding.node_index import DescribedNode, DescribedObject, written

_MAX_SDO = 32
"""Bits of a value in an expedited SDO message."""
_TIMES = ("time_of_day", "time_difference")
_REALS = {"r32": 32, "r64": 64}


def object_signals(
    node: DescribedNode, thing: DescribedObject, first: int, bits: int
) -> Iterator[Signal]:
    """Yield the signals of an object that has these bits of a PDO: two for a time, else one."""
    kind = thing.kind
    name = thing.name or f"object_{written(thing.number).replace(':', '_')}"
    comment = _comment(node, thing)
    if kind in _TIMES and bits >= KIND_BITS[kind]:
        days = "days" if kind == "time_difference" else "days since 1984-01-01"
        yield Signal(f"{name}_ms", first, 28, unit="ms", comment=comment)
        yield Signal(
            f"{name}_days", first + 32, 16, unit="d", comment=f"{comment}; {days}"
        )
        return
    signal = Signal(name, first, bits, signed=kind in SIGNED_KINDS, comment=comment)
    if bits >= _REALS.get(kind, bits + 1):
        signal = replace(signal, bits=_REALS[kind], real=True)
    values = thing.value_names
    if kind == "bool":
        values = {0: "false", 1: "true"}
    if is_number(thing, bits):
        factor = 1 if thing.factor is None else thing.factor
        limits = sorted((factor * (thing.low or 0), factor * (thing.high or 0)))
        if thing.low is None or thing.high is None:
            limits = [0, 0]
        signal = replace(signal, factor=factor, low=limits[0], high=limits[1])
    yield replace(signal, unit=thing.unit, values=values)


def is_number(thing: DescribedObject, bits: int) -> bool:
    """Return whether a value with these bits is a number in a DBC file as in the object."""
    kind = thing.kind
    if kind in _REALS:
        return bits >= _REALS[kind]
    return kind in KIND_BITS and kind not in ("bool", "char", *_TIMES)


def sdo_signal(
    node: DescribedNode, thing: DescribedObject, first: int, selector: str
) -> Signal:
    """Return the signal of an object in the 4 octets of an expedited message.

    Of an object that is longer, or whose length is not fixed, it has the octets.
    """
    width = KIND_BITS.get(thing.kind, _MAX_SDO)
    bits = min((width + 7) // 8 * 8, _MAX_SDO)
    short = thing if width <= _MAX_SDO else replace(thing, kind="octets", factor=None)
    [signal] = object_signals(node, short, first, bits)
    number = multiplexed_number(thing)
    return replace(
        signal, comment="", selector=selector, when=(range(number, number + 1),)
    )


def multiplexed_number(thing: DescribedObject) -> int:
    """Return index and sub-index as the number that SDO and multiplexed PDOs have of an object."""
    index, subindex = thing.number
    return index | subindex << 16


def object_names(node: DescribedNode) -> dict[int, str]:
    """Return the objects by the number that SDO has of them."""
    return {multiplexed_number(o): str(o) for o in node.objects.values()}


def _comment(node: DescribedNode, thing: DescribedObject) -> str:
    variable = node.device.find(*thing.number)
    words = [written(thing.number)]
    if variable is not None:
        words += [variable.name, f"({variable.type_name})", variable.description]
    return " ".join(filter(None, words))
