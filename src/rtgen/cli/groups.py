"""Click groups whose commands are imported lazily."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from typing import Any

import click

from rtgen.cli.examples import EXAMPLES
from rtgen.cli.help import write_description, write_example
from rtgen.compiler.kit.translation import translated

EXITS = "0 success, 1 negative result, 2 wrong input, 3 failed environment"
"""The exit codes of all commands."""


class LazyGroup(click.Group):
    """A group of commands with their help lines.

    `target` is the `module:function` of a command `{0}`; `elsewhere` has those of other modules.
    `hidden` are older names, which work and are not shown.
    """

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
        self._summaries = summaries
        self._target = target
        self._elsewhere = elsewhere or {}
        self._hidden = hidden

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(self._summaries)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        if cmd_name not in self._summaries and cmd_name not in self._hidden:
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

            close = get_close_matches(name, self._summaries, n=1)
            hint = f" Did you mean {close[0]!r}?" if close else ""
            ctx.fail(f"No such command {name!r}.{hint}")
        return super().resolve_command(ctx, args)

    def format_help_text(
        self, ctx: click.Context, formatter: click.HelpFormatter
    ) -> None:
        write_description(self, formatter)

    def format_commands(
        self, ctx: click.Context, formatter: click.HelpFormatter
    ) -> None:
        with formatter.section(translated("Commands")):
            formatter.write_dl(
                [(name, translated(text)) for name, text in self._summaries.items()]
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
        rows = [
            (f"{'' if number else title:9}{name}", translated(text))
            for title, commands in self._sections.items()
            if title != "more"
            for number, (name, text) in enumerate(commands.items())
        ]
        formatter.write_paragraph()
        formatter.write_dl(rows)
        formatter.write(f"{'more':9}{more}\n")
        formatter.write(
            f"{'options':9}--version; --language, -h, --help, also of each command\n"
        )
        formatter.write(f"{'exits':9}{translated(EXITS)}\n")
        formatter.write(f"{translated('Example')}: {EXAMPLES['']}\n")

    def format_epilog(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """The example stands with the options."""
