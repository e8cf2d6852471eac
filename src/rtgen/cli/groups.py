"""Click groups whose commands are imported lazily."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from typing import Any

import click

from rtgen.cli.examples import EXAMPLES


class LazyGroup(click.Group):
    """A group of commands with their help lines.

    `target` is the `module:function` of a command `{0}`; `elsewhere` has those of other modules.
    """

    def __init__(
        self,
        *args: Any,
        summaries: Mapping[str, str],
        target: str,
        elsewhere: Mapping[str, str] | None = None,
        **kwargs: Any,
    ) -> None:
        super().__init__(*args, **kwargs)
        self._summaries = summaries
        self._target = target
        self._elsewhere = elsewhere or {}

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(self._summaries)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        if cmd_name not in self._summaries:
            return None
        target = self._elsewhere.get(cmd_name, self._target)
        module, _, function = target.format(cmd_name).partition(":")
        command = getattr(import_module(module), function)
        assert isinstance(command, click.Command)
        path = f"{ctx.command_path} {cmd_name}".removeprefix("rtgen ")
        if path in EXAMPLES:
            command.epilog = f"\b\nExample:\n  {EXAMPLES[path]}"
        return command

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        if args and not args[0].startswith("-") and args[0] not in self._summaries:
            from difflib import get_close_matches

            close = get_close_matches(args[0], self._summaries, n=1)
            hint = f" Did you mean {close[0]!r}?" if close else ""
            ctx.fail(f"No such command {args[0]!r}.{hint}")
        return super().resolve_command(ctx, args)

    def format_commands(
        self, ctx: click.Context, formatter: click.HelpFormatter
    ) -> None:
        with formatter.section("Commands"):
            formatter.write_dl(list(self._summaries.items()))
