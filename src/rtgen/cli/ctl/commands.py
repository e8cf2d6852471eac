"""The commands of `rtgen ctl`."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import click

from rtgen.cli.ctl.common import (
    CtlOptions,
    Refused,
    asker,
    joined,
    judged_profile_of,
    print_json,
    settled,
    with_json,
    with_system,
)
from rtgen.cli.help import command
from rtgen.cli.parameter_types import FiniteRange
from rtgen.compiler.kit.translation import translated_word
from rtgen.facts.columns import table
from rtgen.tools.kit.console import Console, write_out
from rtgen.tools.kit.exits import NO, OK
from rtgen.tools.running.control_texts import (
    condition_text,
    description_json,
    port_lines,
    state_json,
    state_name,
    state_row,
    state_text,
    units,
    value_line,
)

if TYPE_CHECKING:
    from rtgen.runtime.distribution.control import Asker

_POLL_INTERVAL = 0.1
_HEADER = ("instance", "state", "ticks", "overruns")

_instances = click.argument("instances", nargs=-1, required=True, metavar="INSTANCE...")


@command("list")
@with_json
@with_system
def list_(console: Console, options: CtlOptions, as_json: bool) -> int:
    """List the components of all processes with their states.

    With --system, also report components that no process has, those in ERROR, and misfit ports.
    """
    profile = judged_profile_of(console, options)
    with joined(console, options, profile) as peers:
        states = [(name, peers.asker(name).state()) for name in settled(peers, options)]
    if as_json:
        print_json([state_json(name, state) for name, state in states])
    elif not states:
        console.say("no process of this system has a component")
    else:
        rows = [
            tuple(map(translated_word, _HEADER)),
            *(state_row(name, state) for name, state in states),
        ]
        write_out("".join(f"{line}\n" for line in table(rows, right=(2, 3))))
    if profile is not None:
        instances = [c.instance for c in profile.components]
        console.say(f"condition: {condition_text(instances, dict(states))}")
    return OK if states else NO


@command("show")
@click.argument("instance", metavar="INSTANCE")
@with_json
@with_system
def show_(console: Console, options: CtlOptions, instance: str, as_json: bool) -> int:
    """Show a component: state, ports, services, parameters."""
    with joined(console, options) as peers:
        asked = asker(peers, instance, options)
        state, described, sets = asked.state(), asked.describe(), asked.parameters()
    if as_json:
        shown = {
            **state_json(instance, state),
            **description_json(described),
            "active_set": sets.active,
            "sets": sets.sets,
            "units": units(described),
        }
        print_json(shown)
        return OK
    lines = [
        f"{instance}: {described.type}, {translated_word(state_text(state))}",
        *port_lines(described),
    ]
    in_units = units(described)
    values = sets.sets.get(sets.active, {})
    lines += (value_line(n, v, in_units.get(n)) for n, v in values.items())
    write_out("".join(f"{line}\n" for line in lines))
    return OK


@command("activate")
@_instances
@with_system
def activate_(console: Console, options: CtlOptions, instances: tuple[str, ...]) -> int:
    """Activate components; exit code 1 if one refuses or ends in ERROR."""
    return _steer(console, options, instances, lambda a: a.activate(), "ACTIVE")


@command("deactivate")
@_instances
@with_system
def deactivate_(
    console: Console, options: CtlOptions, instances: tuple[str, ...]
) -> int:
    """Deactivate components; exit code 1 if one refuses or ends in ERROR."""
    return _steer(console, options, instances, lambda a: a.deactivate(), "INACTIVE")


@command("reset")
@_instances
@with_system
def reset_(console: Console, options: CtlOptions, instances: tuple[str, ...]) -> int:
    """Reset components that are in ERROR; exit code 1 if one refuses."""
    return _steer(console, options, instances, lambda a: a.reset(), "INACTIVE")


@command("watch")
@click.argument("instances", nargs=-1, metavar="[INSTANCE]...")
@click.option(
    "--for",
    "seconds",
    type=FiniteRange(min=0, min_open=True),
    metavar="SECONDS",
    help="Stop after this time; default: at Ctrl-C.",
)
@with_json
@with_system
def watch_(
    console: Console,
    options: CtlOptions,
    instances: tuple[str, ...],
    seconds: float | None,
    as_json: bool,
) -> int:
    """Print the states of components, then each change; default: of all components."""
    from rtgen.runtime.distribution.watching import Watch

    begun = time.monotonic()
    with joined(console, options) as peers:
        watch = Watch(peers, instances)
        try:
            while seconds is None or time.monotonic() - begun < seconds:
                for change in watch.look():
                    at = round(time.monotonic() - begun, 3)
                    if as_json:
                        event = state_json(change.instance, change.state)
                        write_out(f"{json.dumps({'time': at, **event})}\n")
                    else:
                        name = change.instance
                        text = translated_word(state_text(change.state))
                        write_out(f"{at:.3f} s: {name} {text}\n")
                peers.wait(_POLL_INTERVAL)
        except KeyboardInterrupt:
            console.say("")
    return OK


def _steer(
    console: Console,
    options: CtlOptions,
    instances: Sequence[str],
    request: Callable[[Asker], str],
    target: str,
) -> int:
    """Request a state of components one after the other, waiting until each has it."""
    with joined(console, options) as peers:
        for instance in instances:
            asked = asker(peers, instance, options)
            before = asked.state().state
            code = request(asked)
            if code != "RTC_OK":
                state = state_text(asked.state())
                raise Refused(f"{instance} refuses: {code}; it is {state}")
            deadline = time.monotonic() + options.wait
            while (state := state_name(now := asked.state())) != target:
                failed = state == "ERROR" and now.state != before
                if failed or time.monotonic() > deadline:
                    raise Refused(f"{instance} is {state_text(now)}, not {target}")
                peers.wait(_POLL_INTERVAL)
            console.say(f"{instance} {target}")
    return OK
