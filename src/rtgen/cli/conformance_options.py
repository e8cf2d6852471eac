"""Options of `rtgen conformance`: what is tested, where it is, and what a test may do."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

import click

from rtgen.cli.can.options import with_bus
from rtgen.cli.help import grouped
from rtgen.cli.parameter_types import FiniteRange, WholeRange
from rtgen.cli.rpc.common import with_representation
from rtgen.runtime.opaque_rpc.serial import BAUDRATE
from rtgen.tools.conformance.check import Permission
from rtgen.tools.conformance.subject import Subject


def with_subject(command: Callable[..., int]) -> Callable[..., int]:
    """Add the options; the function gets them as `subject`."""

    @click.option(
        "--connect",
        metavar="WAY:WHERE",
        help="tcp:HOST:PORT, serial:DEVICE, HOST[:PORT]/NAME.rtc, corbaname:..., or a bus: "
        "socketcan:can0.",
    )
    @click.option(
        "--timeout",
        type=FiniteRange(min=0.01),
        default=1.0,
        metavar="SECONDS",
        help="For each response; default: 1.",
    )
    @grouped(
        "Permissions",
        click.option(
            "--actuate",
            is_flag=True,
            help="Also what may move something: OPERATIONAL, writes, calls, activation.",
        ),
        click.option(
            "--defaults",
            is_flag=True,
            help="Compare values with the definition's defaults.",
        ),
        click.option(
            "--exit",
            "may_exit",
            is_flag=True,
            help="Call exit of the component at the end.",
        ),
    )
    @grouped(
        "Boards",
        click.option(
            "--signature",
            metavar="SIG",
            help="Signature of the board, if there are several.",
        ),
        click.option(
            "--function",
            "functions",
            multiple=True,
            metavar="NAME",
            help="Call only this function; may be repeated.",
        ),
        click.option(
            "--baud",
            type=WholeRange(min=1),
            default=BAUDRATE,
            metavar="N",
            help=f"Of a serial line; default: {BAUDRATE}.",
        ),
        click.option(
            "--stall",
            type=FiniteRange(min=0.01),
            metavar="SECONDS",
            help="The board must drop a stalled client then.",
        ),
    )
    @with_representation
    @grouped(
        "Components",
        click.option(
            "--component",
            metavar="NAME",
            help="Name of the component, if there are several.",
        ),
        click.option(
            "-I",
            "include",
            multiple=True,
            metavar="DIR",
            help="Search DIR for types of ports.",
        ),
    )
    @grouped(
        "Nodes",
        click.option(
            "--node",
            "node_id",
            type=WholeRange(1, 127),
            metavar="NODE-ID",
            help="Default: that of a DCF.",
        ),
        click.option(
            "--boot",
            type=FiniteRange(min=0.01),
            default=5.0,
            metavar="SECONDS",
            help="For the boot-up; default: 5.",
        ),
    )
    @with_bus
    @functools.wraps(command)
    def wrapped(
        *args: Any,
        actuate: bool,
        defaults: bool,
        may_exit: bool,
        connect: str | None,
        **kwargs: Any,
    ) -> int:
        names = {*Subject.__dataclass_fields__} - {"connect", "permissions"}
        subject = Subject(
            connect=connect or "",
            permissions=[
                each
                for each, is_given in (
                    (Permission.ACTUATE, actuate),
                    (Permission.DEFAULTS, defaults),
                    (Permission.EXIT, may_exit),
                )
                if is_given
            ],
            **{name: kwargs.pop(name) for name in names},
        )
        return command(*args, subject=subject, **kwargs)

    return wrapped
