"""The commands of `rtgen ctl` for configuration parameters."""

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
from rtgen.tools.kit.exits import OK, Refusal
from rtgen.tools.running.control_texts import units, value_line

_set_option = click.option(
    "--in",
    "set_id",
    metavar="SET",
    help="Configuration set; default: the active one.",
)


@command("get")
@click.argument("names", nargs=-1, required=True, metavar="INSTANCE[.PARAMETER]...")
@_set_option
@with_json
@with_system
def get_(
    console: Console,
    options: CtlOptions,
    names: tuple[str, ...],
    set_id: str | None,
    as_json: bool,
) -> int:
    """Print the values of parameters."""
    by_instance: dict[str, dict[str, str]] = {}
    in_units: dict[str, dict[str, str]] = {}
    with joined(console, options) as peers:
        for name in names:
            instance, _, parameter = name.partition(".")
            asked = asker(peers, instance, options)
            sets = asked.parameters()
            if not as_json:
                in_units[instance] = units(asked.describe())
            values = sets.sets.get(sets.active if set_id is None else set_id)
            if values is None:
                choices = ", ".join(sets.sets)
                raise Refused(f"{instance} has no set {set_id!r}; known: {choices}")
            if parameter and parameter not in values:
                choices = ", ".join(values) or "none"
                raise Refused(
                    f"{instance} has no configuration parameter {parameter!r}; known: {choices}"
                )
            chosen = {parameter: values[parameter]} if parameter else values
            by_instance.setdefault(instance, {}).update(chosen)
    if as_json:
        print_json(by_instance)
        return OK
    lines = [
        value_line(f"{i}.{n}", v, in_units[i].get(n))
        for i, values in by_instance.items()
        for n, v in values.items()
    ]
    write_out("".join(f"{line}\n" for line in lines))
    return OK


@command("set")
@click.argument(
    "settings", nargs=-1, required=True, metavar="INSTANCE.PARAMETER=VALUE..."
)
@_set_option
@with_system
def set_(
    console: Console,
    options: CtlOptions,
    settings: tuple[str, ...],
    set_id: str | None,
) -> int:
    """Set parameters; a component applies them between two of its cycles.

    Exit code 1: a component refuses a value, and the reason is printed. Earlier values stay set.
    """
    parts = [_setting(text) for text in settings]
    with joined(console, options) as peers:
        for instance, parameter, value in parts:
            asker(peers, instance, options).set(parameter, value, set_id)
    return OK


@command("use")
@click.argument("instance", metavar="INSTANCE")
@click.argument("set_id", metavar="SET")
@with_system
def use_(console: Console, options: CtlOptions, instance: str, set_id: str) -> int:
    """Activate a configuration set."""
    with joined(console, options) as peers:
        asker(peers, instance, options).activate_set(set_id)
    return OK


def _setting(text: str) -> tuple[str, str, str]:
    """Return the parts of `INSTANCE.PARAMETER=VALUE`. Raises Refusal."""
    name, equals, value = text.partition("=")
    instance, dot, parameter = name.partition(".")
    if not (equals and dot and instance and parameter):
        raise Refusal(f"{text!r} is not INSTANCE.PARAMETER=VALUE")
    return instance, parameter, value
