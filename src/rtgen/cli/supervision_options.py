"""Options of `rtgen run` beside `--supervise`."""

from __future__ import annotations

from itertools import chain

import click
from click.core import ParameterSource

from rtgen.tools.kit.exits import Refusal
from rtgen.tools.running.transports import ACTIVATED, TAKES

_NOT_PASSED_ON = frozenset(
    {"system", "clock", "until", "settings", "nameserver", "form", "colour", "language"}
    | {"supervise", "groups", "restarts", "quiet"}
)
"""Options of `rtgen run` that are compatible with `--supervise`, but not passed on unchanged."""


_COMPATIBLE = (
    _NOT_PASSED_ON
    | {"timeline_file", "verbose", "fail_on", "transport", "checkpoints"}
    | {*chain(*TAKES.values())}
) - {"only", ACTIVATED}
"""All options that are compatible with it."""

_HANDED_ON = frozenset({ParameterSource.COMMANDLINE, ParameterSource.DEFAULT_MAP})
"""Sources of the options that processes get: the command line, and `[run]`."""


def check_options(context: click.Context) -> None:
    """Raise Refusal for an option that is incompatible with `--supervise`."""
    for parameter in context.command.params:
        name = parameter.name or ""
        source = context.get_parameter_source(name)
        if source is ParameterSource.COMMANDLINE and name not in _COMPATIBLE:
            raise Refusal(f"--supervise does not go with {parameter.opts[-1]}")


def handed_on(context: click.Context) -> list[str]:
    """Return the options that each process gets unchanged."""
    words: list[str] = []
    for parameter in context.command.params:
        name = parameter.name or ""
        source = context.get_parameter_source(name)
        if source not in _HANDED_ON or name in _NOT_PASSED_ON:
            continue
        value = context.params.get(name)
        text = ",".join(value) if isinstance(value, tuple) else str(value)
        is_flag = isinstance(parameter, click.Option) and (
            parameter.is_flag or parameter.count
        )
        words += (
            [parameter.opts[-1]] * int(value or 0)
            if is_flag
            else [parameter.opts[-1], text]
        )
    return words
