"""The command `rtgen lsp`: the language server."""

from __future__ import annotations

import gc
import linecache
import logging
import os
import sys
from contextlib import redirect_stdout

import click

from rtgen.cli.help import command
from rtgen.cli.options import with_console
from rtgen.compiler.diagnostics import ToolError
from rtgen.facts.extras import installation
from rtgen.tools.kit.console import Console
from rtgen.tools.kit.exits import OK


@command()
@click.option(
    "--log-level",
    type=click.Choice(["error", "warning", "info", "debug"]),
    default="error",
    show_default=True,
    help="Level of the log on standard error.",
)
@with_console
def lsp(console: Console, log_level: str) -> int:
    """Run the language server: diagnostics, hover, definitions, completion, rename, hints.

    The server implements the Language Server Protocol on standard input and output until its
    editor stops it. Editors start the server; docs/editors.md has the settings of each. The server
    requires the extra `lsp`: pip install ./runtime '.[lsp]' in a clone of rtgen.
    """
    logging.basicConfig(level=log_level.upper(), stream=sys.stderr)
    if log_level != "debug":  # it logs rejected requests with a traceback
        logging.getLogger("pygls").setLevel(logging.CRITICAL)
    try:
        from attrs import validators

        from rtgen.tools.lsp.messages import FramingError
        from rtgen.tools.lsp.server import make_server
    except ModuleNotFoundError as error:
        if (error.name or "").partition(".")[0] not in ("attrs", "pygls", "lsprotocol"):
            raise
        message = "the language server needs pygls"
        raise ToolError(message, installation("lsp")) from None
    # Responses are sent between the steps of an analysis; large collections are rare.
    sys.setswitchinterval(0.001)
    gc.set_threshold(100_000, 20, 20)
    # The source of each method that attrs writes, for debuggers: 3 MB.
    linecache.clearcache()
    # Skip validation: features create valid positions, and it takes a third of a response's time.
    validators.set_disabled(True)
    # The protocol has its own streams, so that a stray print cannot corrupt its messages.
    with (
        os.fdopen(os.dup(sys.stdin.fileno()), "rb") as requests,
        os.fdopen(os.dup(sys.stdout.fileno()), "wb") as answers,
        redirect_stdout(sys.stderr),
    ):
        try:
            make_server().start_io(requests, answers)
        except FramingError as error:
            message = f"the input is not of the Language Server Protocol: {error}"
            hint = "editors start this command: docs/editors.md"
            raise ToolError(message, hint) from None
    return OK
