"""What `[run]` of the project says, for parameters that the command line leaves open."""

from __future__ import annotations

import functools
from collections.abc import Callable, Collection, Mapping
from typing import Any

import click
from click.core import ParameterSource

from rtgen.compiler.project import ENGINES, RunTable, load_run_table, shown
from rtgen.tools.kit.console import Console

GIVEN = frozenset({ParameterSource.COMMANDLINE, ParameterSource.ENVIRONMENT})
"""Sources of parameters that a user has given; `[run]` is DEFAULT_MAP."""


def with_run_table(
    **parameters: str,
) -> Callable[[Callable[..., int]], Callable[..., int]]:
    """Return a decorator for a command, to be placed directly below its console.

    `parameters` has the name of the parameter by the key of `[run]`. With `until`, the function
    also gets `until_at`, the place of a condition that is not the command line's.
    """

    def decorate(function: Callable[..., int]) -> Callable[..., int]:
        @functools.wraps(function)
        def wrapped(console: Console, **values: Any) -> int:
            context = click.get_current_context()
            given = {n for n in values if context.get_parameter_source(n) in GIVEN}
            table = RunTable()
            if not values.pop("is_told", False) and not given >= {*parameters.values()}:
                table = load_run_table()
            taken = _taken(table, parameters, given, values)
            if "record" in taken and _is_divided(values):
                del taken["record"]
                console.say("[run] record is left out: it is that of one process")
            for key, value in taken.items():
                name = parameters[key]
                values[name] = context.params[name] = value
                context.set_parameter_source(name, ParameterSource.DEFAULT_MAP)
            if "until" in parameters:
                values["until_at"] = table.spans["until"] if "until" in taken else None
            return function(console, **values)

        return wrapped

    return decorate


def _taken(
    table: RunTable,
    parameters: Mapping[str, str],
    given: Collection[str],
    values: Mapping[str, Any],
) -> dict[str, str]:
    """Return the values of the table by key, without those that do not go with given ones."""
    answers = {
        "system": None if table.system is None else shown(table.system),
        "clock": table.clock,
        "until": table.until,
        "transport": table.transport,
        "partition": table.partition,
        "record": None if table.record is None else shown(table.record),
    }
    taken = {
        key: answer
        for key, answer in answers.items()
        if answer is not None and key in parameters and parameters[key] not in given
    }
    is_simulated = taken.get("clock", values.get("clock")) == "sim"
    if is_simulated and taken.get("transport") in ENGINES:
        del taken["transport"]
    transport = taken.get("transport", values.get("transport"))
    if transport not in ENGINES or _is_other(
        table, parameters["system"], given, values
    ):
        taken.pop("partition", None)
    return taken


def _is_divided(values: Mapping[str, Any]) -> bool:
    """Return whether the command runs a part of a system, or several processes."""
    return values.get("only") is not None or values.get("supervise") is not None


def _is_other(
    table: RunTable, name: str, given: Collection[str], values: Mapping[str, Any]
) -> bool:
    """Return whether the command line names another system than the table."""
    return table.system is not None and name in given and not table.is_of(values[name])


def required(system: str | None) -> str:
    """Return the system. Raises click.UsageError if neither place names one."""
    if system is None:
        raise click.UsageError(
            "Missing argument 'SYSTEM', and `[run] system` in rtgen.toml."
        )
    return system
