"""Reports on a network, for readers: its start-up, write by write, and its timing."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

from rtgen.compiler.backends.canopen.literals import named
from rtgen.compiler.backends.canopen.network_module import identity
from rtgen.compiler.layouts.can_messages import Writings, messages
from rtgen.compiler.layouts.can_startup import StartWrite, start_up
from rtgen.compiler.layouts.can_supervision import (
    guard_time,
    heartbeat,
    heartbeat_timeout,
)
from rtgen.compiler.layouts.can_timing import Message, Timing, load, response_times
from rtgen.compiler.model.can_bus import Bus, BusNode
from rtgen.facts.columns import table

_IDENTITY = ("1000 device type", "1018:1 vendor", "1018:2 product", "1018:3 revision")


def start_up_text(bus: Bus, header: Sequence[str]) -> str:
    """Return the start-up of each node by the manager of a network, in order.

    Raises CanValueError for a value that cannot be written.
    """
    lines = [*(f"# {line}" for line in header), "", *_about(bus)]
    for node in bus.nodes:
        lines += ["", f"Node {node.id}, {node.name}: {node.kind.module}"]
        lines += _table(list(_steps(node)), "  ")
    return "\n".join(lines) + "\n"


def _about(bus: Bus) -> Iterator[str]:
    yield f"Network {bus.name}: {bus.bit_rate} kbit/s, manager {bus.manager}"
    if bus.sync:
        yield f"SYNC every {_milliseconds(bus.sync)} ms"
    if bus.heartbeat:
        yield f"Heartbeat of the manager every {_milliseconds(bus.heartbeat)} ms"


def _steps(node: BusNode) -> Iterator[list[str]]:
    yield ["NMT", "82", "reset communication"]
    yield ["wait", "", "boot-up message", f"{_milliseconds(node.boot_timeout)} ms"]
    if node.lss:
        yield ["LSS", "", "node-id, if it has none"]
    names = (*_IDENTITY, "1018:4 serial number")
    for name, wanted in zip(names, identity(node), strict=True):
        if wanted is not None:
            number, _, what = name.partition(" ")
            yield ["check", number, what, f"{wanted:08X}h"]
    writes = start_up(node)
    for write in writes:
        variable = write.variable
        place = named(variable.index, variable.subindex)
        yield ["write", place, _what(write), write.value.hex(" ").upper()]
    if any(write.verify for write in writes):
        yield ["read", "", "what was written"]
    if node.start:
        yield ["NMT", "01", "start"]
    patience = heartbeat_timeout(node)
    if (period := heartbeat(node)) and patience:
        times = f"every {period} ms, lost after {patience} ms"
        yield ["watch", "1017", "heartbeat", times]
    if period := guard_time(node):
        times = f"every {period} ms, lost after {patience} ms"
        yield ["guard", "100C", "node guarding", times]
    if node.restarts:
        yield ["reset", "", f"after errors, up to {node.restarts} times"]


def _what(write: StartWrite) -> str:
    name = write.variable.name
    return f"{name} ({write.why})" if write.why else name


def timing_text(
    bus: Bus,
    header: Sequence[str],
    writings: Writings | None = None,
    *,
    said: Callable[[str], str] = str,
) -> str:
    """Return load and worst-case response time of every message, the most urgent first.

    `writings`: see `messages`. `said` translates the words of the table.
    """
    sent = messages(bus, writings)
    timings = list(response_times(sent, bus.bit_rate))
    rows = [[*map(said, _HEAD)], *(_timing(timing, said) for timing in timings)]
    late = [t for t in timings if t.response is None or t.response > t.message.period]
    lines = [
        *(f"# {line}" for line in header),
        "",
        *_about(bus),
        f"Load: {load(sent, bus.bit_rate):.1%} at most",
        "",
        *_table(rows, ""),
        "",
        "All times in us. Response: from the event to the end of the frame, worst case",
        "(Davis, Burns, Bril, Lukkien: Controller Area Network schedulability analysis, 2007).",
        "Synchronous PDOs count from SYNC. What manager and proxies send waits in one queue.",
    ]
    if late:
        names = ", ".join(t.message.name for t in late)
        lines.append(f"Not before the next one is due: {names}.")
    return "\n".join(lines) + "\n"


_HEAD = ["identifier", "message", "octets", "period", "frame", "response"]


def _timing(timing: Timing, said: Callable[[str], str]) -> list[str]:
    message = timing.message
    return [
        _identifier(message),
        message.name,
        str(message.octets),
        _microseconds(message.period),
        _microseconds(timing.transmission),
        said("no bound") if timing.response is None else _microseconds(timing.response),
    ]


def _identifier(message: Message) -> str:
    return f"{message.identifier:0{8 if message.extended else 3}X}h"


def _microseconds(nanoseconds: int) -> str:
    whole, rest = divmod(nanoseconds, 1000)
    return str(whole) if not rest else f"{whole}.{rest:03}".rstrip("0")


def _milliseconds(seconds: float) -> str:
    return f"{seconds * 1000:.6f}".rstrip("0").rstrip(".")


def _table(rows: Sequence[Sequence[str]], margin: str) -> list[str]:
    """Return rows with columns of equal width."""
    return [f"{margin}{line}".rstrip() for line in table(rows, on_terminal=False)]
