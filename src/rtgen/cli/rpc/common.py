"""Options shared by the commands of `rtgen rpc`, and lookup of signatures and functions."""

from __future__ import annotations

import functools
import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import ParamSpec, TypeVar

import click

from rtgen.cli.common import Refusal
from rtgen.cli.rpc.codecs import Function, Service
from rtgen.cli.rpc.values import Json
from rtgen.diagnostics import InputError, has_errors
from rtgen.facts.encodings import decode
from rtgen.facts.opaque_rpc import TIMEOUT
from rtgen.files import UnreadableError, read_file
from rtgen.layouts.tdr import TransferError
from rtgen.model.tecs import Signature, TecsUnit
from rtgen.runtime.opaque_rpc import REPLY_LIMIT, Order, ReplyOrder, Tdr, make_tdr
from rtgen.runtime.opaque_rpc.ends import checked_timeout

P = ParamSpec("P")
R = TypeVar("R")


@dataclass(frozen=True, slots=True)
class Wire:
    """Data representation and order of replies of the other end."""

    tdr: Tdr
    reply: ReplyOrder


@dataclass(frozen=True, slots=True)
class Peer:
    """The options for the other end; `timeout` in seconds."""

    wire: Wire
    timeout: float


def _timeout(context: click.Context, option: click.Parameter, value: float) -> float:
    try:
        return checked_timeout(value)
    except ValueError as error:
        raise click.BadParameter(str(error)) from error


def with_representation(function: Callable[P, R]) -> Callable[..., R]:
    """Add --tdr, --reply-order and --long-bits; the function gets `wire`."""

    @click.option(
        "--tdr",
        "order",
        type=click.Choice(["network", "little", "big"]),
        default="network",
        show_default=True,
        help="Data representation: network order, or native to such machines.",
    )
    @click.option(
        "--reply-order",
        type=click.Choice(["tecsgen", "paper"]),
        default="tecsgen",
        show_default=True,
        help="Position of the return value: before or after the outs.",
    )
    @click.option(
        "--long-bits",
        type=click.Choice(["32", "64"]),
        help="Width of long: 32 in network order, else 64.",
    )
    @functools.wraps(function)
    def wrapped(
        order: Order,
        reply_order: ReplyOrder,
        long_bits: str | None,
        *args: P.args,
        **kwargs: P.kwargs,
    ) -> R:
        bits = int(long_bits) if long_bits else None
        wire = Wire(make_tdr(order, long_bits=bits), reply_order)
        return function(*args, wire=wire, **kwargs)  # type: ignore[arg-type]

    return wrapped


def with_peer(function: Callable[P, R]) -> Callable[..., R]:
    """Add --tdr, --reply-order, --long-bits and --timeout; the function gets `peer`."""

    @with_representation
    @click.option(
        "--timeout",
        callback=_timeout,
        type=float,
        default=TIMEOUT,
        show_default=True,
        metavar="S",
        help="Seconds to wait for the peer.",
    )
    @functools.wraps(function)
    def wrapped(wire: Wire, timeout: float, *args: P.args, **kwargs: P.kwargs) -> R:
        return function(*args, peer=Peer(wire, timeout), **kwargs)  # type: ignore[arg-type]

    return wrapped


def with_cdl(function: Callable[P, R]) -> Callable[P, R]:
    """Add --cdl and -I; the function gets `cdl` and `include`."""
    function = click.option(
        "-I",
        "include",
        multiple=True,
        metavar="DIR",
        help="Search DIR for imported files.",
    )(function)
    return click.option(
        "--cdl",
        required=True,
        type=click.Path(dir_okay=False, path_type=Path),
        metavar="FILE",
        help="The CDL file that declares the signature.",
    )(function)


def read_unit(path: Path, include: tuple[str, ...] = ()) -> TecsUnit:
    """Read the declarations of a CDL file; only errors are reported. Raises InputError."""
    from rtgen.frontends import cdl
    from rtgen.project import load

    project = load()
    folders = [*map(Path, include), *project.include, *project.tecs_path]
    result = cdl.load(
        [path],
        root=project.root,
        include=folders,
        define=dict(project.define),
        encoding=project.encoding,
    )
    if has_errors(result.diagnostics):
        raise InputError(list(result.diagnostics))
    return result.model.tecs[0]


def signatures_of(unit: TecsUnit) -> list[Signature]:
    """Return the signatures of a unit."""
    return [d for d in unit.declarations if isinstance(d, Signature)]


def service_of(
    unit: TecsUnit, name: str, wire: Wire, limit: int = REPLY_LIMIT
) -> Service:
    """Find the service of a signature by name. Raises ClickException.

    `limit`: maximum octets of arrays and texts in a request that is read.
    """
    signatures = {d.scoped: d for d in signatures_of(unit)}
    signature = signatures.get(name.removeprefix("::"))
    if signature is None:
        raise _unknown("signature", name, list(signatures))
    try:
        return Service(unit, signature, wire.tdr, wire.reply, limit)
    except TransferError as error:
        raise refused(f"{error.span.file}:{error.span.line}: {error}") from error


def function_of(unit: TecsUnit, name: str, wire: Wire) -> Function:
    """Find the function `SIG.FUNC`. Raises ClickException."""
    signature, dot, function = name.rpartition(".")
    if not dot:
        raise refused(f"{name!r}: name the function as SIGNATURE.FUNCTION")
    service = service_of(unit, signature, wire)
    if function not in service.functions:
        raise _unknown("function", function, list(service.functions))
    return service.functions[function]


def parsed(text: str) -> Json:
    """Parse JSON from the command line. Raises ClickException."""
    try:
        value: Json = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise refused(f"{text[:40]!r} is not JSON: {error}") from error
    return value


def printed(value: Json) -> str:
    """Format JSON as one line with a newline."""
    return f"{json.dumps(value)}\n"


def content(path: Path) -> str:
    """Read a text. Raises ClickException."""
    try:
        return decode(read_file(path), standard=True).normal
    except UnreadableError as error:
        raise refused(f"cannot read {path}: {error}") from error


def octets(text: str) -> bytes:
    """Parse hex digits. Raises ClickException."""
    try:
        return bytes.fromhex(text)
    except ValueError as error:
        digits = "hex digits, two for each octet"
        raise refused(f"{text[:40]!r} is not hex: write {digits}") from error


def _unknown(what: str, name: str, known: list[str]) -> click.ClickException:
    from difflib import get_close_matches

    close = get_close_matches(name, known, n=1)
    hint = f"did you mean {close[0]!r}?" if close else f"known: {', '.join(known)}"
    return refused(f"no {what} {name!r}; {hint}")


def refused(message: str) -> click.ClickException:
    """Return the exception for invalid input."""
    return Refusal(message)
