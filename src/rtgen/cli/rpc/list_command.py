"""The command `rtgen rpc list`: lists signatures and functions."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import click

from rtgen.cli.help import command
from rtgen.cli.options import with_console
from rtgen.cli.rpc.common import with_cdl
from rtgen.compiler.inspection.tecs import declaration
from rtgen.compiler.kit.translation import translated
from rtgen.compiler.layouts.tdr_messages import problems
from rtgen.compiler.model.tecs import TecsFunction, TecsParameter
from rtgen.compiler.typemap.tecs.texts import sizes_text
from rtgen.tools.kit.console import Console, write_out
from rtgen.tools.kit.exits import OK
from rtgen.tools.rpc.signatures import CdlFiles, printed


@command("list")
@click.argument(
    "named",
    metavar="[FILE]",
    required=False,
    type=click.Path(dir_okay=False, path_type=Path),
)
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
@with_cdl
@with_console
def list_(console: Console, cdl: CdlFiles, named: Path | None, as_json: bool) -> int:
    """List the functions of all signatures with their ids.

    A signature that OpaqueRPC does not support is listed with the reason.
    """
    if named is not None:
        if cdl.file is not None:
            raise click.UsageError("name the file once")
        cdl = replace(cdl, file=named)
    signatures = [
        (
            signature,
            [translated(f"not transferable: {p}") for p in problems(unit, signature)],
        )
        for unit, signature in cdl.signatures()
    ]
    if as_json:
        listed = [declaration(s) | {"problems": texts} for s, texts in signatures]
        write_out(printed({"signatures": listed}))
        return OK
    lines = []
    for signature, texts in signatures:
        lines.append(signature.scoped)
        lines += [f"  {f.id:3}  {_declaration(f)}" for f in signature.functions]
        lines += [f"       {text}" for text in texts]
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
