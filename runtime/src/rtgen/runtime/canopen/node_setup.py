"""Identity check and configuration of a node by its manager, before the node is started."""

from __future__ import annotations

from collections.abc import Callable, Generator
from typing import Final, TypeAlias

import msgspec

from rtgen.runtime.canopen.description import NodeDescription, ObjectNumber, Write


class Transfer(msgspec.Struct, frozen=True, gc=False):
    """An SDO read, or a write if there is a `value`.

    A write is `repeatable` if it sets a value and does not execute a command.
    """

    index: int
    subindex: int
    value: bytes | None = None
    repeatable: bool = True


SetUp: TypeAlias = Generator[Transfer, bytes, None]
"""Generator that yields transfers, and receives the octets read (b"" for a write)."""

IDENTITY: Final = (
    (0x1000, 0, "device type"),
    (0x1018, 1, "vendor"),
    (0x1018, 2, "product"),
    (0x1018, 3, "revision"),
    (0x1018, 4, "serial number"),
)
"""The objects of `NodeDescription.identity` in order: index, sub-index, name."""


class SetUpError(Exception):
    """The node has the wrong identity, or does not store written values.

    `final`: a reset would not help.
    """

    def __init__(self, reason: str, *, final: bool = False) -> None:
        self.final = final
        super().__init__(reason)


def set_up(node: NodeDescription, identified: Callable[[], None]) -> SetUp:
    """Compare the identity, then write the configuration and read it back.

    `identified` is called in between. An object that is written several times is read back once,
    at the end. Raises SetUpError.
    """
    for (index, subindex, what), expected in zip(IDENTITY, node.identity, strict=True):
        if expected is None:
            continue
        actual = int.from_bytes((yield Transfer(index, subindex)), "little")
        if actual != expected:
            raise SetUpError(
                f"wrong identity: {what} ({number_text(index, subindex)}) is {actual:08X}h, "
                f"not {expected:08X}h",
                final=True,
            )
    identified()
    last: dict[ObjectNumber, Write] = {}
    for write in node.configuration:
        yield Transfer(write.index, write.subindex, write.value, write.repeatable)
        last[write.index, write.subindex] = write
    for (index, subindex), write in last.items():
        if not write.verify:
            continue
        value_now = yield Transfer(index, subindex)
        if not same(value_now, write.value):
            raise SetUpError(
                f"{number_text(index, subindex)} was written as {write.value.hex(' ')}, "
                f"but reads {value_now.hex(' ')}"
            )


def number_text(index: int, subindex: int) -> str:
    """Format an object's number for users, `1018:1`."""
    return f"{index:04X}:{subindex:X}"


def same(value_now: bytes, written: bytes) -> bool:
    """Return whether the node stored a value; trailing zeros are padding."""
    return value_now.startswith(written) and not any(value_now[len(written) :])
