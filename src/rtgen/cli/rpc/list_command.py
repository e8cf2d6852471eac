"""The command `rtgen rpc list`: lists signatures and functions."""

from __future__ import annotations

from pathlib import Path

import click

from rtgen.cli.options import with_console
from rtgen.cli.rpc.common import with_cdl
from rtgen.compiler.layouts.tdr_messages import problems
from rtgen.compiler.model.tecs import TecsFunction, TecsParameter
from rtgen.compiler.typemap.tecs.texts import sizes_text
from rtgen.tools.kit.console import Console, write_out
from rtgen.tools.kit.exits import OK
from rtgen.tools.rpc.signatures import read_unit, signatures_of


@click.command("list")
@with_cdl
@with_console
def list_(console: Console, cdl: Path, include: tuple[str, ...]) -> int:
    """List the functions of all signatures with their ids.

    A signature that OpaqueRPC does not support is listed with the reason.
    """
    unit = read_unit(cdl, include)
    lines = []
    for signature in signatures_of(unit):
        lines.append(signature.scoped)
        lines += [f"  {f.id:3}  {_declaration(f)}" for f in signature.functions]
        lines += [f"       not transferable: {p}" for p in problems(unit, signature)]
    write_out("".join(f"{line}\n" for line in lines))
    return OK


def _declaration(function: TecsFunction) -> str:
    parameters = ", ".join(map(_parameter, function.parameters)) or "void"
    oneway = "[oneway] " if function.oneway else ""
    return f"{oneway}{function.returns} {function.name}({parameters})"


def _parameter(parameter: TecsParameter) -> str:
    direction = str(parameter.direction.value)
    if parameter.allocator:
        direction += f"({'::'.join(parameter.allocator)})"
    specifiers = ", ".join([direction, *sizes_text(parameter.sizes)])
    return f"[{specifiers}] {parameter.type} {parameter.name}"
