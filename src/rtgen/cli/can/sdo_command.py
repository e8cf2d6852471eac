"""`rtgen can sdo`."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path
from typing import get_args

import click

from rtgen.cli.can.exchange import Exchange, SilentError
from rtgen.cli.can.known import KnownBus, KnownObject, number_of
from rtgen.cli.can.known_values import Field, sdo_value
from rtgen.cli.can.live import opened
from rtgen.cli.can.options import BusAccess, Described, with_bus, with_nodes
from rtgen.cli.can.value_parsing import parsed_value
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
from rtgen.model.canopen import Access
from rtgen.project_rules import SUPERVISED
from rtgen.runtime.canopen.description import Kind
from rtgen.runtime.canopen.frames import ERROR_CONTROL, SDO_REQUEST, SECOND, Frame
from rtgen.runtime.canopen.sdo import SdoAbort
from rtgen.runtime.canopen.values import ObjectValueError, encode

_LOOK = 0.3
"""Seconds that the bus is watched for a manager, if nobody tells how often it beats."""
_LONGEST_LOOK = 2.0
_MINUS = "\N{MINUS SIGN}"
_NEGATIVE = re.compile(r"-\.?\d")
_BLOCKS: tuple[Kind, ...] = ("octets", "string", "wstring")
"""Kinds of values that may be long, and so are read by blocks."""


class _Aborted(click.ClickException):
    """The node refuses."""

    exit_code = NO


class _Command(click.Command):
    """A command one of whose arguments may be a negative number, which looks like an option."""

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
    help="What the value is: u8 to u64, i8 to i64, r32, r64, bool, string, octets, ...; "
    "default: as the description says.",
)
@click.option("--raw", is_flag=True, help="The value as on the bus, without factor.")
@click.option(
    "--file",
    type=click.Path(dir_okay=False, path_type=Path),
    metavar="FILE",
    help="Read the octets into a file, or write those of a file.",
)
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
@click.option(
    "--timeout",
    type=FiniteRange(min=0.001),
    default=1.0,
    show_default=True,
    metavar="S",
    help="Seconds to wait for each answer.",
)
@click.option("--no-look", is_flag=True, help="Do not look for a manager first.")
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
) -> int:
    """Read or write an object of a node.

    NODE is a name of the bus file or a node-id, OBJECT a name of the description or a number such
    as 6040 or 6401:1. Long values go by block transfer where the node has it. Exit code 1: the node
    refuses, and why.
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
    with opened(access.on(known)) as bus:
        watch = _Watch(known, node_id)
        exchange = Exchange(bus, watch)
        if not no_look:
            _look(console, watch, exchange)
        try:
            if octets is not None:
                exchange.download(
                    node_id, *thing.number, octets, timeout=round(timeout * SECOND)
                )
                return OK
            got = exchange.upload(
                node_id,
                *thing.number,
                timeout=round(timeout * SECOND),
                block=file is not None or (bool(thing.name) and thing.kind in _BLOCKS),
            )
        except SdoAbort as abort:
            raise _Aborted(f"{called}: the node refuses: {abort}") from abort
        except SilentError:
            raise ToolError(
                f"{known.name(node_id)} does not answer",
                hint="rtgen can scan tells who is there; a node that is stopped has no SDO",
            ) from None
    if file is not None:
        _write(file, got)
        console.say(f"{len(got)} octets in {file}")
        return OK
    field = Field(known.name(node_id), thing, sdo_value(thing, got))
    if as_json:
        told = {"node": node_id, "node_name": field.node, **field.to_json()}
        write_out(f"{json.dumps(told)}\n")
    else:
        text = field.value if isinstance(field.value, str) else field.text
        write_out(f"{text}\n")
    return OK


def _object(
    known: KnownBus, node_id: int, name: str, kind: Kind | None, *, raw: bool
) -> KnownObject:
    """The variable; of a node that nobody has told of, one of the kind that is asked for."""
    node = known.nodes.get(node_id)
    if node is not None:
        try:
            thing = node.object(name)
        except Refusal:
            # Devices have objects that their descriptions leave out.
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
    return KnownObject(number, "", kind or "octets", Access.RW)


def _as(thing: KnownObject, kind: Kind | None, *, raw: bool) -> KnownObject:
    """The variable as another kind of value, or without its factor and the unit of that."""
    if kind is None and not raw:
        return thing
    unit = "" if thing.factor is not None else thing.unit
    return replace(thing, kind=kind or thing.kind, factor=None, unit=unit)


def _octets(thing: KnownObject, value: str | None, file: Path | None) -> bytes:
    """What is to be written. Raises Refusal, ToolError."""
    if (value is None) == (file is None):
        raise click.UsageError("`write` takes a value, or --file")
    if file is not None:
        try:
            return file.read_bytes()
        except OSError as error:
            raise ToolError(f"cannot read {file}: {error.strerror}") from error
    assert value is not None
    told = parsed_value(thing, value)
    try:
        return encode(thing.kind, told)
    except ObjectValueError as error:
        raise Refusal(f"{thing}: {error}") from error


def _write(file: Path, octets: bytes) -> None:
    try:
        file.write_bytes(octets)
    except OSError as error:
        raise ToolError(f"cannot write {file}: {error.strerror}") from error


class _Watch:
    """Sees whether somebody else is the SDO client of a node."""

    def __init__(self, known: KnownBus, node_id: int) -> None:
        self._manager = ERROR_CONTROL + known.manager
        self._requests = SDO_REQUEST + node_id
        period = known.bus.heartbeat if known.bus else 0.0
        self.seconds = min(2.5 * period, _LONGEST_LOOK) or _LOOK
        self._name = known.name(node_id)
        self._by = f"the manager (node {known.manager})"
        self.found = ""

    def __call__(self, frame: Frame) -> None:
        if frame.extended or frame.remote:
            return
        if frame.can_id == self._manager:
            self.found = f"{self._by} is on the bus, and supervises {self._name}"
        elif frame.can_id == self._requests:
            self.found = f"somebody else reads and writes objects of {self._name}"


def _look(console: Console, watch: _Watch, exchange: Exchange) -> None:
    """Warns if the node has an SDO client already."""
    exchange.listen(watch.seconds, lambda: bool(watch.found))
    if watch.found:
        hint = "use the SDO port of its proxy, or the manager"
        console.findings([SUPERVISED.at(None, watch.found, hint=hint)])
