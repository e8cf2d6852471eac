"""The command `rtgen can hub`: a CAN bus for processes of this machine."""

from __future__ import annotations

import asyncio
import os
import selectors
import signal
import sys
from collections.abc import Callable
from typing import TYPE_CHECKING

import click

from rtgen.cli.help import command
from rtgen.cli.options import with_console
from rtgen.cli.parameter_types import WholeRange
from rtgen.compiler.diagnostics import ToolError
from rtgen.compiler.diagnostics.printable import printable
from rtgen.runtime.canopen.bus.hub import QUEUE, Hub, HubSettings
from rtgen.runtime.canopen.bus.hub_faults import Fault, fault_of
from rtgen.runtime.canopen.bus.python_can import SOCKETCAND_PORT
from rtgen.tools.kit.console import Console, write_out
from rtgen.tools.kit.exits import OK

if TYPE_CHECKING:
    from rtgen.runtime.canopen.bus.hub_pty import SlcanPty


def _faults(
    context: click.Context, option: click.Parameter, values: tuple[str, ...]
) -> tuple[Fault, ...]:
    try:
        return tuple(map(fault_of, values))
    except ValueError as error:
        raise click.BadParameter(str(error), context, option) from error


@command("hub")
@click.option("--host", default="127.0.0.1", show_default=True, metavar="ADDRESS")
@click.option(
    "--port",
    type=WholeRange(0, 65535),
    default=SOCKETCAND_PORT,
    show_default=True,
    help="TCP port; 0: any free port.",
)
@click.option(
    "--bitrate",
    type=WholeRange(0, 1_000_000),
    default=0,
    metavar="BIT/S",
    help="Simulate the transmission time of frames; default: none.",
)
@click.option(
    "--queue",
    type=WholeRange(1, 1_000_000),
    default=QUEUE,
    show_default=True,
    metavar="N",
    help="Maximum number of frames queued for a client, which is disconnected beyond it.",
)
@click.option(
    "--slcan-pty",
    "ptys",
    count=True,
    help="Create a pseudo-terminal for slcan; may be repeated.",
)
@click.option(
    "--slcan-channel",
    default="can0",
    show_default=True,
    metavar="NAME",
    help="Bus of the pseudo-terminals.",
)
@click.option(
    "--fault",
    "faults",
    multiple=True,
    callback=_faults,
    metavar="FAULT",
    help="loss=P[@ID], delay=MS[@ID] or bus-off=AT:FOR (seconds); ID is hex.",
)
@click.option(
    "--seed", type=int, default=0, show_default=True, help="Seed of random faults."
)
@with_console
def hub_(
    console: Console,
    host: str,
    port: int,
    bitrate: int,
    queue: int,
    ptys: int,
    slcan_channel: str,
    faults: tuple[Fault, ...],
    seed: int,
) -> int:
    """Run a CAN bus for the processes of this machine, until Ctrl-C.

    python-can's interface socketcand (with tcp_tune=True) connects to it; each channel name is a
    separate bus. The first line of the output is `listening HOST:PORT`, then `slcan PATH` for each
    pseudo-terminal. Disconnected clients and refused frames are reported on standard error.
    """
    settings = HubSettings(bitrate, queue, faults, seed)
    work = _serve(console, settings, host, port, ptys, slcan_channel)
    with asyncio.Runner(loop_factory=_event_loop_factory(bitrate)) as runner:
        runner.run(work)
    return OK


def _event_loop_factory(bit_rate: int) -> Callable[[], asyncio.AbstractEventLoop]:
    """Return the fastest event loop with precise timers: uvloop's have milliseconds."""
    if not bit_rate:
        try:
            import uvloop
        except ImportError:
            pass
        else:
            return uvloop.new_event_loop
    # select() has a finer time-out than epoll; frames take microseconds.
    return lambda: asyncio.SelectorEventLoop(selectors.SelectSelector())


async def _serve(
    console: Console,
    settings: HubSettings,
    host: str,
    port: int,
    ptys: int,
    channel: str,
) -> None:
    def report(text: str) -> None:
        # Diagnostics are printed with --quiet too.
        sys.stderr.write(f"rtgen can hub: {printable(text)}\n")
        sys.stderr.flush()

    hub = Hub(settings, report)
    try:
        name, number = await hub.listen(host, port)
    except OSError as error:
        # asyncio replaces strerror of an address by a sentence of its own.
        errno = error.errno or 0
        cause = os.strerror(errno) if errno > 0 else error.strerror or str(error)
        raise ToolError(f"cannot listen at {host}:{port}: {cause}") from error
    lines: list[SlcanPty] = []
    try:
        place = f"[{name}]:{number}" if ":" in name else f"{name}:{number}"
        write_out(f"listening {place}\n")
        for _ in range(ptys):
            line = _pseudo_terminal(hub, channel)
            lines.append(line)
            write_out(f"slcan {line.path}\n")
        ended = asyncio.Event()
        for reason in (signal.SIGINT, signal.SIGTERM):
            hub.loop.add_signal_handler(reason, ended.set)
        await ended.wait()
    finally:
        for line in lines:
            line.close()
        await hub.close()
    for text in hub.report():
        console.say(text)


def _pseudo_terminal(hub: Hub, channel: str) -> SlcanPty:
    try:
        from rtgen.runtime.canopen.bus.hub_pty import SlcanPty
    except ImportError as error:
        raise ToolError("this system has no pseudo-terminals") from error
    bus = hub.bus(channel)
    if bus is None:
        raise ToolError(f"{channel!r} is not a name of a channel")
    return SlcanPty(hub, bus)
