"""The command `rtgen can sdo`: reads or writes an object of a node."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path
from typing import get_args

import click

from rtgen.cli.can.decoding.node_index import DescribedObject, NodeIndex, number_of
from rtgen.cli.can.decoding.object_values import Field, decoded
from rtgen.cli.can.live.bus_session import BusSession, SilentError
from rtgen.cli.can.live.live_bus import opened
from rtgen.cli.can.options import BusAccess, Described, with_bus, with_nodes
from rtgen.cli.can.parsing.values import parsed_value
from rtgen.cli.common import (
    NO,
    OK,
    Console,
    FiniteRange,
    Refusal,
    with_console,
    write_out,
)
from rtgen.diagnostics import ToolError
from rtgen.facts.canopen import INVALID
from rtgen.facts.cob_ids import SDO_SERVERS
from rtgen.files import UnreadableError, create_file, read_file
from rtgen.model.canopen import Access
from rtgen.project.rules import SUPERVISED
from rtgen.runtime.canopen.description import Kind
from rtgen.runtime.canopen.values import ObjectValueError, encode
from rtgen.runtime.canopen.wire.frames import (
    ERROR_CONTROL,
    SECOND,
    CobId,
    Frame,
    sdo_cob_ids,
)
from rtgen.runtime.canopen.wire.sdo import SdoAbort

_DEFAULT_WATCH = 0.3
"""Seconds to watch for a manager if no bus file gives its heartbeat period."""
_MAX_WATCH = 2.0
_MINUS = "\N{MINUS SIGN}"
_NEGATIVE = re.compile(r"-\.?\d")
_BLOCKS: tuple[Kind, ...] = ("octets", "string", "wstring")
"""Kinds of values that may be long, and are read by block transfer."""


class _NoValueError(click.ClickException):
    """The node has aborted the transfer, or its answer is not a value of the object."""

    exit_code = NO


class _Command(click.Command):
    """A command that accepts negative numbers as arguments, although they look like options."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        marked = [f"{_MINUS}{a[1:]}" if _NEGATIVE.match(a) else a for a in args]
        return super().parse_args(ctx, marked)


def _unmarked(
    context: click.Context, parameter: click.Parameter, text: str | None
) -> str | None:
    return None if text is None else text.replace(_MINUS, "-", 1)


@click.command("sdo", cls=_Command)
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
    type=click.IntRange(1, len(SDO_SERVERS)),
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
    described: Described,
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
    known = described.known()
    node_id = known.node(node)
    thing = _object(known, node_id, name, kind, raw=raw)
    if action == "read" and value is not None:
        raise click.UsageError("a value is for `write`")
    octets = None
    if action == "write":
        octets = _octets(thing, value, file)
    called = f"{known.name(node_id)} {thing}"
    cob_ids = _server(known, node_id, server)
    with opened(access.on(known)) as bus:
        watch = _OtherClientWatch(known, node_id, cob_ids[0], is_shared=server == 1)
        session = BusSession(bus, watch)
        if not no_look:
            _warn_of_other_client(console, watch, session)
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
                f"{known.name(node_id)} does not answer",
                hint="`rtgen can scan` lists the nodes of the bus; a stopped node has no SDO",
            ) from None
    if file is not None:
        _write(file, got)
        console.say(f"{len(got)} octets in {file}")
        return OK
    try:
        field = Field(known.name(node_id), thing, decoded(thing, got))
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


def _server(known: NodeIndex, node_id: int, server: int) -> tuple[CobId, CobId]:
    """Return the COB-IDs of an SDO server of a node. Raises Refusal for one that is not valid."""
    if server == 1:
        return sdo_cob_ids(node_id)
    node, index = known.nodes.get(node_id), SDO_SERVERS[server - 1]
    parameters = {} if node is None else node.parameters
    request, response = (
        CobId(parameters.get((index, sub), INVALID) & 0xFFFFFFFF) for sub in (1, 2)
    )
    if not (request.valid and response.valid):
        raise Refusal(
            f"{known.name(node_id)} has no SDO server {server}: its description gives "
            f"{index:04X}h no two valid COB-IDs"
        )
    return request, response


def _object(
    known: NodeIndex, node_id: int, name: str, kind: Kind | None, *, raw: bool
) -> DescribedObject:
    """Return the object; for a node without a description, an unnamed one of the requested kind."""
    node = known.nodes.get(node_id)
    if node is not None:
        try:
            thing = node.object(name)
        except Refusal:
            # Devices have objects that their descriptions omit.
            if kind is None or number_of(name) is None:
                raise
        else:
            return _as(thing, kind, raw=raw)
    number = number_of(name)
    if number is None:
        raise Refusal(
            f"{known.name(node_id)} is not described, so {name!r} is not known: give --bus or "
            "--eds, or write the number, such as 6401:1"
        )
    return DescribedObject(number, "", kind or "octets", Access.RW)


def _as(thing: DescribedObject, kind: Kind | None, *, raw: bool) -> DescribedObject:
    """Return the object with another kind, or without factor and its unit."""
    if kind is None and not raw:
        return thing
    unit = "" if thing.factor is not None else thing.unit
    return replace(thing, kind=kind or thing.kind, factor=None, unit=unit)


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


def _write(file: Path, octets: bytes) -> None:
    try:
        with create_file(file) as stream:
            stream.write(octets)
    except OSError as error:
        raise ToolError(f"cannot write {file}: {error.strerror}") from error


class _OtherClientWatch:
    """Detects another SDO client of the node's server; the manager is one if it `is_shared`."""

    def __init__(
        self, known: NodeIndex, node_id: int, requests: CobId, *, is_shared: bool
    ) -> None:
        self._manager = ERROR_CONTROL + known.manager if is_shared else None
        self._requests = requests
        period = known.bus.heartbeat if known.bus else 0.0
        self.seconds = min(2.5 * period, _MAX_WATCH) or _DEFAULT_WATCH
        self._name = known.name(node_id)
        self._by = f"the manager (node {known.manager})"
        self.found = ""

    def __call__(self, frame: Frame) -> None:
        if frame.remote:
            return
        if frame.can_id == self._manager and not frame.extended:
            self.found = f"{self._by} is on the bus, and supervises {self._name}"
        elif self._requests.carries(frame):
            self.found = f"somebody else reads and writes objects of {self._name}"


def _warn_of_other_client(
    console: Console, watch: _OtherClientWatch, session: BusSession
) -> None:
    """Warn if the node already has an SDO client."""
    session.listen(watch.seconds, lambda: bool(watch.found))
    if watch.found:
        hint = "use the SDO port of its proxy, or the manager"
        console.findings([SUPERVISED.at(None, watch.found, hint=hint)])
