"""The command `rtgen can sdo`: reads or writes an object of a node."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import get_args

import click

from rtgen.cli.can.options import with_bus, with_nodes
from rtgen.cli.help import Command, command
from rtgen.cli.options import with_console
from rtgen.cli.parameter_types import FiniteRange, WholeRange
from rtgen.compiler.diagnostics import ToolError
from rtgen.facts.cob_ids import SDO_SERVERS
from rtgen.facts.files import UnreadableError, read_file
from rtgen.runtime.canopen.description import Kind
from rtgen.runtime.canopen.values import ObjectValueError, encode
from rtgen.runtime.canopen.wire.frames import SECOND
from rtgen.runtime.canopen.wire.sdo import SdoAbort
from rtgen.tools.can.access import BusAccess, NodeFiles
from rtgen.tools.can.decoding.node_index import DescribedObject
from rtgen.tools.can.decoding.object_values import Field, decoded
from rtgen.tools.can.live.bus_session import BusSession, SilentError
from rtgen.tools.can.live.live_bus import opened
from rtgen.tools.can.live.objects import (
    OtherClientWatch,
    requested_object,
    server_cob_ids,
    warn_of_other_client,
)
from rtgen.tools.can.parsing.values import parsed_value
from rtgen.tools.kit.console import Console, write_out
from rtgen.tools.kit.exits import NO, OK, Refusal
from rtgen.tools.kit.files import save

_MINUS = "\N{MINUS SIGN}"
_NEGATIVE = re.compile(r"-\.?\d")
_BLOCKS: tuple[Kind, ...] = ("octets", "string", "wstring")
"""Kinds of values that may be long, and are read by block transfer."""


class _NoValueError(click.ClickException):
    """The node has aborted the transfer, or its answer is not a value of the object."""

    exit_code = NO


class _Command(Command):
    """A command that accepts negative numbers as arguments, although they look like options."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        marked = [f"{_MINUS}{a[1:]}" if _NEGATIVE.match(a) else a for a in args]
        return super().parse_args(ctx, marked)


def _unmarked(
    context: click.Context, parameter: click.Parameter, text: str | None
) -> str | None:
    return None if text is None else text.replace(_MINUS, "-", 1)


@command("sdo", cls=_Command)
@click.argument("action", type=click.Choice(["read", "write"]))
@click.argument("node", metavar="NODE")
@click.argument("name", metavar="OBJECT")
@click.argument("value", required=False, callback=_unmarked)
@click.option(
    "--type",
    "kind",
    type=click.Choice(get_args(Kind)),
    metavar="KIND",
    help="Type of the value: u8 to u64, i8 to i64, r32, r64, bool, string, octets, ...; "
    "default: from the description.",
)
@click.option(
    "--raw", is_flag=True, help="Use the raw value of the bus, without a factor."
)
@click.option(
    "--file",
    type=click.Path(dir_okay=False, path_type=Path),
    metavar="FILE",
    help="Read octets into a file, or write the octets of a file.",
)
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
@click.option(
    "--timeout",
    type=FiniteRange(min=0.001),
    default=1.0,
    show_default=True,
    metavar="S",
    help="Seconds to wait for each response.",
)
@click.option("--no-look", is_flag=True, help="Do not check for a manager first.")
@click.option(
    "--server",
    type=WholeRange(1, len(SDO_SERVERS)),
    default=1,
    metavar="N",
    help="The SDO server of the node: 2 is that of 1201h in its description, for a second client.",
)
@with_nodes
@with_bus
@with_console
def sdo_(
    console: Console,
    access: BusAccess,
    node_files: NodeFiles,
    action: str,
    node: str,
    name: str,
    value: str | None,
    kind: Kind | None,
    raw: bool,
    file: Path | None,
    as_json: bool,
    timeout: float,
    no_look: bool,
    server: int,
) -> int:
    """Read or write an object of a node.

    NODE is a name of the bus file or a node-id, OBJECT a name of the description or a number such
    as 6040 or 6401:1. Long values use block transfer if the node supports it. Exit code 1: the node
    refuses, or an answer is missing or not valid: what has happened to which message is printed.
    """
    node_index = node_files.read(console)
    node_id = node_index.node(node)
    thing = requested_object(node_index, node_id, name, kind, raw=raw)
    if action == "read" and value is not None:
        raise click.UsageError("a value is for `write`")
    octets = _octets(thing, value, file) if action == "write" else None
    called = f"{node_index.name(node_id)} {thing}"
    cob_ids = server_cob_ids(node_index, node_id, server)
    with opened(access.on(node_index)) as bus:
        watch = OtherClientWatch(node_index, node_id, cob_ids[0], is_shared=server == 1)
        session = BusSession(bus, watch)
        if not no_look:
            warn_of_other_client(console, watch, session)
        try:
            if octets is not None:
                session.download(
                    node_id,
                    *thing.number,
                    octets,
                    timeout=round(timeout * SECOND),
                    cob_ids=cob_ids,
                )
                return OK
            got = session.upload(
                node_id,
                *thing.number,
                timeout=round(timeout * SECOND),
                block=file is not None or (bool(thing.name) and thing.kind in _BLOCKS),
                cob_ids=cob_ids,
            )
        except SdoAbort as abort:
            raise _NoValueError(f"{called}: {abort.explanation}") from abort
        except SilentError:
            raise ToolError(
                f"{node_index.name(node_id)} does not answer",
                hint="`rtgen can scan` lists the nodes of the bus; a stopped node has no SDO",
            ) from None
    if file is not None:
        save(file, got)
        console.say(f"{len(got)} octets in {file}")
        return OK
    try:
        field = Field(node_index.name(node_id), thing, decoded(thing, got))
    except ObjectValueError as error:
        raise _NoValueError(
            f"{called}: the answer is not valid: {error}; `--type octets` prints it"
        ) from error
    if as_json:
        parsed = {"node": node_id, "node_name": field.node, **field.to_json()}
        write_out(f"{json.dumps(parsed)}\n")
    else:
        text = field.value if isinstance(field.value, str) else field.text
        write_out(f"{text}\n")
    return OK


def _octets(thing: DescribedObject, value: str | None, file: Path | None) -> bytes:
    """Return the octets to write. Raises Refusal, ToolError."""
    if (value is None) == (file is None):
        raise click.UsageError("`write` requires a value, or --file")
    if file is not None:
        try:
            return read_file(file)
        except UnreadableError as error:
            raise ToolError(f"cannot read {file}: {error}") from error
    assert value is not None
    parsed = parsed_value(thing, value)
    try:
        return encode(thing.kind, parsed)
    except ObjectValueError as error:
        raise Refusal(f"{thing}: {error}") from error
