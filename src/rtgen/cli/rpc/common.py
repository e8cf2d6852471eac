"""Options shared by the commands of `rtgen rpc`, and lookup of signatures and functions."""

from __future__ import annotations

import functools
from collections.abc import Callable
from pathlib import Path
from typing import Any, ParamSpec, TypeVar

import click

from rtgen.cli.help import grouped
from rtgen.facts.opaque_rpc import TIMEOUT
from rtgen.runtime.opaque_rpc import Order, ReplyOrder, make_tdr
from rtgen.runtime.opaque_rpc.ends import checked_timeout
from rtgen.tools.rpc.signatures import CdlFiles, Peer, Wire

P = ParamSpec("P")
R = TypeVar("R")


def _timeout(context: click.Context, option: click.Parameter, value: float) -> float:
    try:
        return checked_timeout(value)
    except ValueError as error:
        raise click.BadParameter(str(error)) from error


def with_representation(function: Callable[P, R]) -> Callable[..., R]:
    """Add --tdr, --reply-order and --long-bits; the function gets `wire`."""

    @grouped(
        "Boards",
        click.option(
            "--tdr",
            "order",
            type=click.Choice(["network", "little", "big"]),
            default="network",
            metavar="ORDER",
            help="Octets: network (default); little, big: as such machines.",
        ),
        click.option(
            "--reply-order",
            type=click.Choice(["tecsgen", "paper"]),
            default="tecsgen",
            metavar="ORDER",
            help="Return value first (tecsgen), or last (paper).",
        ),
        click.option(
            "--long-bits",
            type=click.Choice(["32", "64"]),
            help="Default: 32 in network order, else 64.",
        ),
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
    @grouped(
        "Boards",
        click.option(
            "--timeout",
            callback=_timeout,
            type=float,
            default=TIMEOUT,
            metavar="SECONDS",
            help=f"Wait for the peer; default: {TIMEOUT:g}.",
        ),
    )
    @functools.wraps(function)
    def wrapped(wire: Wire, timeout: float, *args: P.args, **kwargs: P.kwargs) -> R:
        return function(*args, peer=Peer(wire, timeout), **kwargs)  # type: ignore[arg-type]

    return wrapped


def with_cdl(function: Callable[..., R]) -> Callable[..., R]:
    """Add --cdl and -I; the function gets `cdl`."""

    @click.option(
        "--cdl",
        type=click.Path(dir_okay=False, path_type=Path),
        metavar="FILE",
        help="The CDL file; default: those in [sources].",
    )
    @click.option(
        "-I",
        "include",
        multiple=True,
        metavar="DIR",
        help="Search DIR for imported files.",
    )
    @functools.wraps(function)
    def wrapped(
        *args: Any, cdl: Path | None, include: tuple[str, ...], **kwargs: Any
    ) -> R:
        return function(*args, cdl=CdlFiles(cdl, include), **kwargs)

    return wrapped
