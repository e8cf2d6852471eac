"""Options shared by the commands of `rtgen rpc`, and lookup of signatures and functions."""

from __future__ import annotations

from pathlib import Path

import click

from rtgen.cli.help import gathered
from rtgen.facts.opaque_rpc import TIMEOUT
from rtgen.runtime.opaque_rpc import Order, ReplyOrder, make_tdr
from rtgen.runtime.opaque_rpc.ends import checked_timeout
from rtgen.tools.rpc.signatures import CdlFiles, Peer, Wire


def _timeout(context: click.Context, option: click.Parameter, value: float) -> float:
    try:
        return checked_timeout(value)
    except ValueError as error:
        raise click.BadParameter(str(error)) from error


def _wire(*, order: Order, reply_order: ReplyOrder, long_bits: str | None) -> Wire:
    bits = int(long_bits) if long_bits else None
    return Wire(make_tdr(order, long_bits=bits), reply_order)


_REPRESENTATION = (
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

with_representation = gathered("wire", _wire, *_REPRESENTATION, title="Boards")

with_peer = gathered(
    "peer",
    lambda *, timeout, **wire: Peer(_wire(**wire), timeout),
    *_REPRESENTATION,
    click.option(
        "--timeout",
        callback=_timeout,
        type=float,
        default=TIMEOUT,
        metavar="SECONDS",
        help=f"Wait for the peer; default: {TIMEOUT:g}.",
    ),
    title="Boards",
)

with_cdl = gathered(
    "cdl",
    lambda *, cdl, include: CdlFiles(cdl, include),
    click.option(
        "--cdl",
        type=click.Path(dir_okay=False, path_type=Path),
        metavar="FILE",
        help="The CDL file; default: those in [sources].",
    ),
    click.option(
        "-I",
        "include",
        multiple=True,
        metavar="DIR",
        help="Search DIR for imported files.",
    ),
)
