"""The command `rtgen rpc serve`: serves a signature as a mock device."""

from __future__ import annotations

import logging
from pathlib import Path

import click

from rtgen.cli.help import command
from rtgen.cli.options import with_console
from rtgen.cli.parameter_types import WholeRange
from rtgen.cli.rpc.common import with_cdl, with_peer
from rtgen.compiler.diagnostics import ToolError
from rtgen.facts.opaque_rpc import FIRST_PORT
from rtgen.runtime.opaque_rpc import (
    REQUEST_LIMIT,
    ChannelError,
    SerialServer,
    TcpServer,
)
from rtgen.runtime.opaque_rpc.messages import log
from rtgen.runtime.opaque_rpc.serial import BAUDRATE
from rtgen.tools.kit.console import Console, write_out
from rtgen.tools.kit.exits import OK, Refusal
from rtgen.tools.rpc.board import MockBoard, ScriptError
from rtgen.tools.rpc.signatures import CdlFiles, Peer, content


@command("serve")
@click.option("--signature", required=True, metavar="SIG", help="Signature to serve.")
@click.option("--host", default="127.0.0.1", show_default=True, metavar="ADDRESS")
@click.option(
    "--port",
    type=WholeRange(0, 65535),
    default=FIRST_PORT,
    show_default=True,
    help="TCP port; 0: any free port.",
)
@click.option("--serial", metavar="DEV", help="Serve a serial line.")
@click.option("--baud", type=WholeRange(min=1), default=BAUDRATE, show_default=True)
@click.option(
    "--script",
    type=click.Path(dir_okay=False, path_type=Path),
    metavar="FILE",
    help="Replies to calls: a JSON object per line.",
)
@click.option(
    "--echo",
    is_flag=True,
    help="Reply with 0, unchanged inouts and zero outs (default).",
)
@click.option("--verbose", is_flag=True, help="Print each call as JSON.")
@with_cdl
@with_peer
@with_console
def serve_(
    console: Console,
    cdl: CdlFiles,
    signature: str,
    host: str,
    port: int,
    serial: str | None,
    baud: int,
    script: Path | None,
    echo: bool,
    verbose: bool,
    peer: Peer,
) -> int:
    """Simulate a device until Ctrl-C. The first line of the output is `listening HOST:PORT`.

    A line of a script is {"function": ..., "args": {...}, "return": ..., "outs": {...}, "delay":
    SECONDS}; args, outs and delay are optional. A call uses the first unused line that matches its
    function and arguments; the last matching line is reused. A call without a matching line gets no
    reply: the connection is closed. Outs missing from a line have the values of --echo.
    """
    if script is not None and echo:
        raise click.UsageError("--script and --echo exclude each other")
    service = cdl.service(signature, peer.wire, REQUEST_LIMIT)
    text = None
    if script is not None:
        text = content(script)
    try:
        board = MockBoard(service, text, print_call=write_out if verbose else None)
    except ScriptError as error:
        raise Refusal(f"{script}:{error.line}: {error}") from error
    server: TcpServer | SerialServer
    try:
        if serial:
            server = SerialServer(board, serial, baud, peer.timeout)
            place = serial
        else:
            server = TcpServer(board, host, port, peer.timeout)
            name, number = server.address
            place = f"[{name}]:{number}" if ":" in name else f"{name}:{number}"
    except (OSError, ChannelError) as error:
        reason = getattr(error, "strerror", None) or error
        raise ToolError(
            f"cannot serve at {serial or f'{host}:{port}'}: {reason}"
        ) from error
    report = _Report(console)
    log.addHandler(report)
    log.setLevel(logging.INFO)
    write_out(f"listening {place}\n")
    try:
        server.serve_forever()
    except ChannelError as error:
        raise ToolError(str(error)) from error
    except KeyboardInterrupt:
        return OK
    finally:
        server.close()
        log.removeHandler(report)
    return OK


class _Report(logging.Handler):
    """Prints why a connection was closed, with the traceback of an exception."""

    def __init__(self, console: Console) -> None:
        super().__init__()
        self._console = console

    def emit(self, record: logging.LogRecord) -> None:
        self._console.say(self.format(record))
