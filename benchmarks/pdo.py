"""PDO coding: the generated codec beside the `canopen` package's own access to PDO variables.

    python benchmarks/pdo.py

Four INTEGER16, then eight BOOLEAN and a 24-bit integer. Rounds of both are interleaved; the median
of a call is printed in nanoseconds, with its ratio to ours.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Sequence
from types import ModuleType
from typing import Any

import canopen

from rtgen.backends.canopen.pdo_codec import PdoCodec, module_text
from rtgen.layouts.pdo import Mapped, layout
from rtgen.model.canopen import DataType

ROUNDS = 25
SECONDS_PER_ROUND = 0.004
MAPPINGS: dict[str, tuple[list[Mapped], tuple[int, ...]]] = {
    "four INTEGER16": (
        [Mapped(f"f{n}", DataType.INTEGER16, 16) for n in range(4)],
        (-32768, -1, 0, 32767),
    ),
    "eight BOOLEAN, one UNSIGNED24": (
        [
            *(Mapped(f"f{n}", DataType.BOOLEAN, 1) for n in range(8)),
            Mapped("f8", DataType.UNSIGNED24, 24),
        ],
        (True, False, True, True, False, False, True, False, 0x123456),
    ),
}


def ours(mapped: Sequence[Mapped], values: tuple[int, ...]) -> list[Callable[[], Any]]:
    """Encode and decode with the generated codec."""
    module = ModuleType("codec")
    text = module_text([PdoCodec("tpdo1", "TPDO 1", layout(mapped))])
    exec(compile(text, "codec", "exec"), module.__dict__)
    encode, decode = module.encode_tpdo1, module.decode_tpdo1
    data = encode(*values)
    assert decode(data) == values
    return [lambda: encode(*values), lambda: decode(data)]


def theirs(
    mapped: Sequence[Mapped], values: tuple[int, ...]
) -> list[Callable[[], Any]]:
    """The same through a PdoMap of the package."""
    node = canopen.RemoteNode(1, canopen.ObjectDictionary())
    canopen.Network().add_node(node)
    pdo = canopen.pdo.base.PdoMap(node.tpdo, None, None)
    for number, entry in enumerate(mapped):
        variable = canopen.objectdictionary.ODVariable(entry.name, 0x2000 + number)
        variable.data_type = int(entry.data_type)
        node.object_dictionary.add_object(variable)
        pdo.add_variable(0x2000 + number, 0, entry.bits)

    def encode() -> bytes:
        for field, value in zip(pdo.map, values, strict=True):
            field.raw = value
        return bytes(pdo.data)

    def decode() -> tuple[int, ...]:
        return tuple(field.raw for field in pdo.map)

    encode()
    assert decode() == values
    return [encode, decode]


def seconds_per_call(task: Callable[[], object]) -> float:
    """The time of a call, over a round."""
    calls, start = 0, time.perf_counter()
    while (taken := time.perf_counter() - start) < SECONDS_PER_ROUND:
        for _ in range(20):
            task()
        calls += 20
    return taken / calls


def main() -> None:
    print(f"{'mapping':<32}{'':<8}{'ours [ns]':>10}{'canopen [ns]':>14}{'ratio':>8}")
    for name, (mapped, values) in MAPPINGS.items():
        tasks = zip(ours(mapped, values), theirs(mapped, values), strict=True)
        for what, pair in zip(("encode", "decode"), tasks, strict=True):
            rounds = [[seconds_per_call(task) for task in pair] for _ in range(ROUNDS)]
            mine, other = (
                statistics.median(r[side] for r in rounds) for side in (0, 1)
            )
            figures = f"{mine * 1e9:>10.0f}{other * 1e9:>14.0f}{other / mine:>8.1f}"
            print(f"{name:<32}{what:<8}{figures}")


if __name__ == "__main__":
    main()
