"""Click groups whose commands are imported lazily."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from typing import Any

import click

from rtgen.cli.examples import EXAMPLES
from rtgen.cli.formatting import Context
from rtgen.cli.help import (
    language_option,
    write_description,
    write_example,
    write_usage,
)
from rtgen.compiler.kit.translation import translated, translated_word
from rtgen.facts.columns import columns, padded

EXITS = "0 success, 1 negative result, 2 wrong input, 3 failed environment"
"""The exit codes of all commands."""


_LAST = {
    "options": "--version; --language, -h, --help, also of each command",
    "exits": EXITS,
}
"""The last lines of the program's help, by their titles."""
_GAP = 2


class LazyGroup(click.Group):
    """A group of commands with their help lines.

    `target` is the `module:function` of a command `{0}`; `elsewhere` has those of other modules.
    `hidden` are older names, which work and are not shown.
    """

    context_class = Context

    def __init__(
        self,
        *args: Any,
        summaries: Mapping[str, str],
        target: str,
        elsewhere: Mapping[str, str] | None = None,
        hidden: frozenset[str] = frozenset(),
        **kwargs: Any,
    ) -> None:
        super().__init__(*args, **kwargs)
        self.params.append(language_option())
        self.summaries = summaries
        self._target = target
        self._elsewhere = elsewhere or {}
        self._hidden = hidden

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(self.summaries)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        if cmd_name not in self.summaries and cmd_name not in self._hidden:
            return None
        target = self._elsewhere.get(cmd_name, self._target)
        module, _, function = target.format(cmd_name).partition(":")
        command = getattr(import_module(module), function)
        assert isinstance(command, click.Command)
        return command

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        name = args[0] if args else ""
        if name and not name.startswith("-") and self.get_command(ctx, name) is None:
            from difflib import get_close_matches

            close = get_close_matches(name, self.summaries, n=1)
            hint = f" Did you mean {close[0]!r}?" if close else ""
            ctx.fail(f"No such command {name!r}.{hint}")
        return super().resolve_command(ctx, args)

    def format_usage(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        write_usage(self, ctx, formatter)

    def format_help_text(
        self, ctx: click.Context, formatter: click.HelpFormatter
    ) -> None:
        write_description(self, formatter)

    def format_options(
        self, ctx: click.Context, formatter: click.HelpFormatter
    ) -> None:
        records = [each.get_help_record(ctx) for each in self.get_params(ctx)]
        with formatter.section(translated_word("Options")):
            formatter.write_dl([(n, translated(t)) for n, t in filter(None, records)])
        self.format_commands(ctx, formatter)

    def format_commands(
        self, ctx: click.Context, formatter: click.HelpFormatter
    ) -> None:
        with formatter.section(translated_word("Commands")):
            formatter.write_dl(
                [(name, translated(text)) for name, text in self.summaries.items()]
            )

    def format_epilog(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        write_example(ctx, formatter)


class SectionedGroup(LazyGroup):
    """A group whose commands are in sections; its help fits a screen.

    The section "more" names its commands only.
    """

    def __init__(
        self, *args: Any, sections: Mapping[str, Mapping[str, str]], **kwargs: Any
    ) -> None:
        summaries = {n: text for each in sections.values() for n, text in each.items()}
        super().__init__(*args, summaries=summaries, **kwargs)
        self._sections = sections

    def format_options(
        self, ctx: click.Context, formatter: click.HelpFormatter
    ) -> None:
        more = ", ".join(self._sections["more"])
        titles = {title: translated_word(title) for title in (*self._sections, *_LAST)}
        width = max(map(columns, titles.values())) + _GAP
        rows = [
            (
                f"{padded('' if number else titles[title], width)}{name}",
                translated(text),
            )
            for title, commands in self._sections.items()
            if title != "more"
            for number, (name, text) in enumerate(commands.items())
        ]
        formatter.write_paragraph()
        formatter.write_dl(rows)
        formatter.write(f"{padded(titles['more'], width)}{more}\n")
        for title, text in _LAST.items():
            formatter.write(f"{padded(titles[title], width)}{translated(text)}\n")
        formatter.write(f"{translated_word('Example')}: {EXAMPLES['']}\n")

    def format_epilog(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """The example stands with the options."""
