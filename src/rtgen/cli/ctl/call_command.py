"""The command `rtgen ctl call`: an operation of a component in another process."""

from __future__ import annotations

import click

from rtgen.cli.ctl.common import (
    CtlOptions,
    Refused,
    asker,
    joined,
    print_json,
    with_json,
    with_system,
)
from rtgen.cli.help import command
from rtgen.tools.kit.console import Console, write_out
from rtgen.tools.kit.exits import NO, OK


@command("call", ignore_unknown_options=True)
@click.argument("called", metavar="INSTANCE.PORT.OPERATION[(VALUE,...)]")
@click.argument("values", nargs=-1, metavar="[VALUE]...")
@with_json
@with_system
def call_(
    console: Console,
    options: CtlOptions,
    called: str,
    values: tuple[str, ...],
    as_json: bool,
) -> int:
    """Call an operation of a service, and print its results.

    Values are numbers, true, false, texts, enumerators, [lists] and {member = value}, which are
    typed by the IDL: 'Hand0.grip.open(30.0)', or Hand0.grip.open 30.0. Exit code 1: the operation
    raised an exception.
    """
    from rtgen.compiler.systems.call_texts import CallTextError, parse, parse_value
    from rtgen.tools.running.texts import outcome_json, outcome_text, value_text

    try:
        call = parse(called)
        arguments = [*call.arguments, *(("", parse_value(text)) for text in values)]
    except CallTextError as error:
        raise click.UsageError(str(error)) from None
    with joined(console, options) as peers:
        asked = asker(peers, call.instance, options)
        outcome = asked.call(call.port, call.operation, arguments)
    if outcome.refused:
        raise click.UsageError(f"{call.text}: {outcome.refused}")
    if as_json:
        print_json(outcome_json(outcome))
        return NO if outcome.exception else OK
    if outcome.exception:
        raise Refused(f"{call.text}{outcome_text(outcome)}")
    lines = [] if outcome.result is None else [value_text(outcome.result)]
    lines += (f"{name} = {value_text(value)}" for name, value in outcome.out.items())
    write_out("".join(f"{line}\n" for line in lines))
    return OK
