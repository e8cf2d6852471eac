"""The command `rtgen explain`: documentation of diagnostic codes."""

from __future__ import annotations

import sys

import click

from rtgen.cli.help import command
from rtgen.cli.options import with_console
from rtgen.cli.stored_answers import with_answer
from rtgen.compiler.kit.translation import translated, translated_word
from rtgen.compiler.kit.translation.blocks import blocks, joined
from rtgen.facts.columns import padded, wrapped
from rtgen.tools.kit.console import Console, forget_output, write_error, write_out
from rtgen.tools.kit.exits import BAD_INPUT, OK


@command()
@with_answer
@click.argument("code", required=False)
@with_console
def explain(console: Console, code: str | None) -> int:
    """Explain a diagnostic; without CODE, list all codes."""
    from rtgen.compiler.diagnostics.explain import rule_of, rules, similar, story

    if code is None:
        for rule in rules().values():
            severity = padded(translated_word(rule.severity.value), 7)
            write_out(f"{rule.code}  {severity}  {translated(rule.title)}\n")
        return OK
    explained = rule_of(code)
    if explained is None:
        close = similar(code)
        message = f"unknown code {code!r}; `rtgen explain` lists all"
        if close:
            message = f"unknown code {code!r}; did you mean {', '.join(close)}?"
        write_error(f"{translated(message)}\n")
        return BAD_INPUT
    if sys.stdout.isatty():
        from rich.console import Console as Terminal
        from rich.markdown import Markdown

        forget_output()
        terminal = Terminal()
        terminal.print(Markdown(_broken(story(explained), terminal.width)))
    else:
        write_out(story(explained))
    return OK


def _broken(page: str, width: int) -> str:
    """Return a page whose paragraphs without spaces between words have lines of `width` columns."""
    parts = []
    for block, is_text in blocks(page):
        text = joined(block)
        if (
            is_text
            and "\n" not in text
            and not text.startswith("#")
            and not text.isascii()
        ):
            text = "  \n".join(wrapped(text, width))
        parts.append(text if is_text else block)
    return "\n\n".join(parts)
