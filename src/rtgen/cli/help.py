"""Commands whose help shows their options under titles, and their example."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable, Sequence
from itertools import zip_longest
from typing import Any, Final, TypeVar

import click

from rtgen.cli.examples import EXAMPLES
from rtgen.cli.formatting import Context
from rtgen.compiler.kit.translation import LANGUAGES, translated, translated_word
from rtgen.facts.columns import columns

F = TypeVar("F", bound=Callable[..., Any])

_TITLES = "option_titles"
"""Attribute of a function: the title of its options by their names."""
_WIDEST = 27
"""Columns of an option with its value; a longer one has its text on the next line."""
_MARGIN = 2
"""Columns at the right that click leaves free, twice."""
HELP: Final = {"help_option_names": ["-h", "--help"]}
"""Settings of click for each command and group, which then need none of the one above."""
MESSAGES = "Messages"
"""The title of the options that all commands have."""


def language_option() -> click.Option:
    """Return the option for the language, which `language_of` reads, for a group of commands."""
    return click.Option(["--language"], **_LANGUAGE)


_LANGUAGE: Final[dict[str, Any]] = {
    "type": click.Choice(LANGUAGES),
    "metavar": "NAME",
    "expose_value": False,
    "hidden": True,
}
LANGUAGE = click.option("--language", **_LANGUAGE)
"""The option for the language, of the program and of each command; the program's help names it.

Its value is read before all others, by `language_of`: help and errors do not wait for it.
"""


def language_of(arguments: Sequence[str]) -> str | None:
    """Return the language that a command line chooses with `--language`, in whatever place."""
    chosen = None
    for argument, following in zip_longest(arguments, arguments[1:], fillvalue=""):
        name, equals, value = argument.partition("=")
        if argument == "--":
            break
        text = value if equals else following
        if name == "--language" and text in LANGUAGES:
            chosen = text
    return chosen


def grouped(title: str, *options: Callable[[F], F]) -> Callable[[F], F]:
    """Return a decorator that adds options, in this order, under a title of the help."""

    def decorate(function: F) -> F:
        added = len(_parameters(function))
        for option in reversed(options):
            function = option(function)
        names = (parameter.name for parameter in _parameters(function)[added:])
        before = vars(function).get(_TITLES, {})
        vars(function)[_TITLES] = {**dict.fromkeys(names, title), **before}
        return function

    return decorate


def gathered(
    name: str,
    make: Callable[..., object],
    *options: Callable[[F], F],
    title: str = "Options",
) -> Callable[[Callable[..., int]], Callable[..., int]]:
    """Return a decorator that adds options; the function gets one value for them all, as `name`.

    `make` gets their values by their names, and returns that value.
    """

    def decorate(function: Callable[..., int]) -> Callable[..., int]:
        added = len(_parameters(function))

        @functools.wraps(function)
        def wrapped(*args: Any, **kwargs: Any) -> int:
            values = {each: kwargs.pop(each) for each in names}
            return function(*args, **{name: make(**values)}, **kwargs)

        adding: Callable[[Any], Any] = grouped(title, *options)
        decorated: Callable[..., int] = adding(wrapped)
        names = [str(each.name) for each in _parameters(decorated)[added:]]
        return decorated

    return decorate


def _parameters(function: Callable[..., Any]) -> list[click.Parameter]:
    """Return the parameters that decorators have added to a function so far."""
    parameters: list[click.Parameter] = vars(function).get("__click_params__", [])
    return parameters


class Command(click.Command):
    """A command of rtgen: its help has no blank line that a reader can do without."""

    context_class = Context

    def format_usage(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        write_usage(self, ctx, formatter)

    def format_options(
        self, ctx: click.Context, formatter: click.HelpFormatter
    ) -> None:
        titles = getattr(self.callback, _TITLES, {})
        groups: dict[str, list[tuple[str, str]]] = {"Options": []}
        for parameter in self.get_params(ctx):
            record = parameter.get_help_record(ctx)
            if record is not None and isinstance(parameter, click.Option):
                is_help = parameter is self.get_help_option(ctx)
                title = titles.get(parameter.name, MESSAGES if is_help else "Options")
                groups.setdefault(title, []).append(record)
        last = groups.pop(MESSAGES, [])
        _write(formatter, [*groups.items(), (MESSAGES, last)])

    def format_help_text(
        self, ctx: click.Context, formatter: click.HelpFormatter
    ) -> None:
        write_description(self, formatter)

    def format_epilog(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        write_example(ctx, formatter)


def _write(
    formatter: click.HelpFormatter,
    groups: Sequence[tuple[str, list[tuple[str, str]]]],
) -> None:
    rows = []
    for title, records in groups:
        if records:
            rows.append((f"{translated_word(title)}:", ""))
            rows += [(f"  {option}", _option_text(text)) for option, text in records]
    formatter.write_paragraph()
    formatter.width += _MARGIN
    formatter.write_dl(rows, col_max=_WIDEST)


def _option_text(text: str) -> str:
    """Return the text of an option in the language; click adds defaults and ranges to it."""
    own, bracket, added = text.partition("  [")
    extra = "; ".join(map(translated, added.removesuffix("]").split("; ")))
    return f"{translated(own)}{bracket}{extra}{']' * bool(bracket)}"


def write_usage(
    command: click.Command, ctx: click.Context, formatter: click.HelpFormatter
) -> None:
    """Write how a command is called."""
    prefix = f"{translated_word('Usage')}: "
    formatter.width -= columns(prefix) - len(prefix)
    formatter.write_usage(
        ctx.command_path, " ".join(command.collect_usage_pieces(ctx)), prefix
    )
    formatter.width += columns(prefix) - len(prefix)


def write_description(command: click.Command, formatter: click.HelpFormatter) -> None:
    """Write what a command does, each paragraph in the language if it is translated."""
    paragraphs = inspect.cleandoc(command.help or "").split("\n\n")
    text = "\n\n".join(translated(" ".join(p.split())) for p in paragraphs)
    formatter.write_paragraph()
    with formatter.indentation():
        formatter.write_text(text)


def write_example(ctx: click.Context, formatter: click.HelpFormatter) -> None:
    """Write the example of a command or a group, if there is one."""
    example = EXAMPLES.get(ctx.command_path.partition(" ")[2])
    if example is not None:
        formatter.write_paragraph()
        formatter.write(f"{translated_word('Example')}: {example}\n")


def command(
    name: str | None = None, cls: type[Command] = Command, **settings: bool
) -> Callable[[Callable[..., int]], Command]:
    """Return a decorator that makes a function a command, by default of its own name.

    `settings` are those of click for its context.
    """
    return click.command(name, cls, context_settings={**HELP, **settings})
