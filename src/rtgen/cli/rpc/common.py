"""Options shared by the commands of `rtgen rpc`, and lookup of signatures and functions."""

from __future__ import annotations

import functools
from collections.abc import Callable
from pathlib import Path
from typing import ParamSpec, TypeVar

import click

from rtgen.facts.opaque_rpc import TIMEOUT
from rtgen.runtime.opaque_rpc import Order, ReplyOrder, make_tdr
from rtgen.runtime.opaque_rpc.ends import checked_timeout
from rtgen.tools.rpc.signatures import Peer, Wire

P = ParamSpec("P")
R = TypeVar("R")


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
