"""The command `rtgen explain`: documentation of diagnostic codes."""

from __future__ import annotations

import sys

import click

from rtgen.cli.help import command
from rtgen.cli.options import with_console
from rtgen.compiler.kit.translation import translated
from rtgen.facts.columns import padded
from rtgen.tools.kit.console import Console, write_out
from rtgen.tools.kit.exits import BAD_INPUT, OK


@command()
@click.argument("code", required=False)
@with_console
def explain(console: Console, code: str | None) -> int:
    """Explain a diagnostic; without CODE, list all codes."""
    from rtgen.compiler.diagnostics.explain import rules, similar, story

    by_code = rules()
    if code is None:
        for rule in by_code.values():
            severity = padded(translated(rule.severity.value), 7)
            write_out(f"{rule.code}  {severity}  {translated(rule.title)}\n")
        return OK
    explained = by_code.get(code.upper())
    if explained is None:
        close = similar(code)
        hint = (
            f"; did you mean {', '.join(close)}?"
            if close
            else "; `rtgen explain` lists all"
        )
        click.echo(f"unknown code {code!r}{hint}", err=True)
        return BAD_INPUT
    if sys.stdout.isatty():
        from rich.console import Console as Terminal
        from rich.markdown import Markdown

        Terminal().print(Markdown(story(explained)))
    else:
        write_out(story(explained))
    return OK
