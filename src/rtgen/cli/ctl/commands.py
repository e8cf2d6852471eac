"""The commands of `rtgen ctl`."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import click

from rtgen.cli.common import (
    NO,
    OK,
    Console,
    FiniteRange,
    Refusal,
    with_console,
    write_out,
)
from rtgen.cli.ctl.common import (
    CtlOptions,
    Refused,
    asker,
    joined,
    profile_of,
    settled,
    with_system,
)

if TYPE_CHECKING:
    from rtgen.runtime.distribution.control import Asker, State
    from rtgen.runtime.distribution.descriptions import Description, Interface

_POLL_INTERVAL = 0.1
_HEADER = ("instance", "state", "ticks", "overruns")

_json = click.option("--json", "as_json", is_flag=True, help="Print JSON.")
_instances = click.argument("instances", nargs=-1, required=True, metavar="INSTANCE...")
_set_option = click.option(
    "--in",
    "set_id",
    metavar="SET",
    help="Configuration set; default: the active one.",
)


@click.command("list")
@_json
@with_system
@with_console
def list_(console: Console, options: CtlOptions, as_json: bool) -> int:
    """List the components of all processes with their states.

    With --system, also report components that no process has, and components in ERROR.
    """
    profile = profile_of(console, options)
    with joined(console, options, profile) as peers:
        states = [(name, peers.asker(name).state()) for name in settled(peers, options)]
    if as_json:
        _print([_state(name, state) for name, state in states])
    elif not states:
        console.say("no process of this system has a component")
    else:
        from rtgen.cli.running.summary import table

        rows = [
            (name, _shown(state), str(state.ticks), str(state.overruns))
            for name, state in states
        ]
        write_out("".join(f"{line}\n" for line in table(_HEADER, rows, (0, 1))))
    if profile is not None:
        wanted = [c.instance for c in profile.components]
        console.say(f"condition: {_condition(wanted, dict(states))}")
    return OK if states else NO


def _condition(wanted: Sequence[str], states: Mapping[str, State]) -> str:
    """Return the condition of a system, in the words of `rtgen run --supervise`."""
    lost = ", ".join(name for name in wanted if name not in states)
    failed = ", ".join(
        name for name in wanted if name in states and _name(states[name]) == "ERROR"
    )
    parts = [f"without {lost}"] * bool(lost) + [f"{failed} in ERROR"] * bool(failed)
    return ", ".join(["degraded", *parts]) if parts else "complete"


@click.command("show")
@click.argument("instance", metavar="INSTANCE")
@_json
@with_system
@with_console
def show_(console: Console, options: CtlOptions, instance: str, as_json: bool) -> int:
    """Show a component: state, ports, services, parameters."""
    with joined(console, options) as peers:
        asked = asker(peers, instance, options)
        state, described, sets = asked.state(), asked.describe(), asked.parameters()
    if as_json:
        shown = {
            **_state(instance, state),
            "type": described.type,
            "in_ports": {n: p.type for n, p in described.in_ports.items()},
            "out_ports": {n: p.type for n, p in described.out_ports.items()},
            "providers": [_interface(each) for each in described.providers],
            "consumers": [_interface(each) for each in described.consumers],
            "active_set": sets.active,
            "sets": sets.sets,
        }
        _print(shown)
        return OK
    lines = [f"{instance}: {described.type}, {_shown(state)}", *_ports(described)]
    lines += (f"{n} = {v}" for n, v in sets.sets.get(sets.active, {}).items())
    write_out("".join(f"{line}\n" for line in lines))
    return OK


@click.command("activate")
@_instances
@with_system
@with_console
def activate_(console: Console, options: CtlOptions, instances: tuple[str, ...]) -> int:
    """Activate components; exit code 1 if one refuses or ends in ERROR."""
    return _steer(console, options, instances, lambda a: a.activate(), "ACTIVE")


@click.command("deactivate")
@_instances
@with_system
@with_console
def deactivate_(
    console: Console, options: CtlOptions, instances: tuple[str, ...]
) -> int:
    """Deactivate components; exit code 1 if one refuses or ends in ERROR."""
    return _steer(console, options, instances, lambda a: a.deactivate(), "INACTIVE")


@click.command("reset")
@_instances
@with_system
@with_console
def reset_(console: Console, options: CtlOptions, instances: tuple[str, ...]) -> int:
    """Reset components that are in ERROR; exit code 1 if one refuses."""
    return _steer(console, options, instances, lambda a: a.reset(), "INACTIVE")


@click.command("get")
@click.argument("names", nargs=-1, required=True, metavar="INSTANCE[.PARAMETER]...")
@_set_option
@_json
@with_system
@with_console
def get_(
    console: Console,
    options: CtlOptions,
    names: tuple[str, ...],
    set_id: str | None,
    as_json: bool,
) -> int:
    """Print the values of parameters."""
    found: dict[str, dict[str, str]] = {}
    with joined(console, options) as peers:
        for name in names:
            instance, _, parameter = name.partition(".")
            sets = asker(peers, instance, options).parameters()
            values = sets.sets.get(sets.active if set_id is None else set_id)
            if values is None:
                known = ", ".join(sets.sets)
                raise Refused(f"{instance} has no set {set_id!r}; known: {known}")
            if parameter and parameter not in values:
                known = ", ".join(values) or "none"
                raise Refused(
                    f"{instance} has no configuration parameter {parameter!r}; known: {known}"
                )
            chosen = {parameter: values[parameter]} if parameter else values
            found.setdefault(instance, {}).update(chosen)
    if as_json:
        _print(found)
        return OK
    lines = [f"{i}.{n} = {v}" for i, values in found.items() for n, v in values.items()]
    write_out("".join(f"{line}\n" for line in lines))
    return OK


@click.command("set")
@click.argument(
    "settings", nargs=-1, required=True, metavar="INSTANCE.PARAMETER=VALUE..."
)
@_set_option
@with_system
@with_console
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


@click.command("use")
@click.argument("instance", metavar="INSTANCE")
@click.argument("set_id", metavar="SET")
@with_system
@with_console
def use_(console: Console, options: CtlOptions, instance: str, set_id: str) -> int:
    """Activate a configuration set."""
    with joined(console, options) as peers:
        asker(peers, instance, options).activate_set(set_id)
    return OK


@click.command("watch")
@click.argument("instances", nargs=-1, metavar="[INSTANCE]...")
@click.option(
    "--for",
    "seconds",
    type=FiniteRange(min=0, min_open=True),
    metavar="SECONDS",
    help="Stop after this time; default: at Ctrl-C.",
)
@_json
@with_system
@with_console
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
                        event = _state(change.instance, change.state)
                        write_out(f"{json.dumps({'time': at, **event})}\n")
                    else:
                        name = change.instance
                        write_out(f"{at:.3f} s: {name} {_shown(change.state)}\n")
                peers.wait(_POLL_INTERVAL)
        except KeyboardInterrupt:
            console.say("")
    return OK


def _steer(
    console: Console,
    options: CtlOptions,
    instances: Sequence[str],
    request: Callable[[Asker], str],
    wanted: str,
) -> int:
    """Request a state of components one after the other, waiting until each has it."""
    with joined(console, options) as peers:
        for instance in instances:
            asked = asker(peers, instance, options)
            before = asked.state().state
            code = request(asked)
            if code != "RTC_OK":
                state = _shown(asked.state())
                raise Refused(f"{instance} refuses: {code}; it is {state}")
            deadline = time.monotonic() + options.wait
            while (state := _name(now := asked.state())) != wanted:
                failed = state == "ERROR" and now.state != before
                if failed or time.monotonic() > deadline:
                    raise Refused(f"{instance} is {_shown(now)}, not {wanted}")
                peers.wait(_POLL_INTERVAL)
            console.say(f"{instance} {wanted}")
    return OK


def _setting(text: str) -> tuple[str, str, str]:
    """Return the parts of `INSTANCE.PARAMETER=VALUE`. Raises Refusal."""
    name, equals, value = text.partition("=")
    instance, dot, parameter = name.partition(".")
    if not (equals and dot and instance and parameter):
        raise Refusal(f"{text!r} is not INSTANCE.PARAMETER=VALUE")
    return instance, parameter, value


def _name(state: State) -> str:
    return state.state.removesuffix("_STATE")


def _shown(state: State | None) -> str:
    if state is None:
        return "lost"
    return f"{_name(state)} ({state.reason})" if state.reason else _name(state)


def _state(instance: str, state: State | None) -> dict[str, Any]:
    if state is None:
        return {"instance": instance, "state": None}
    return {
        "instance": instance,
        "state": _name(state),
        "reason": state.reason,
        "ticks": state.ticks,
        "overruns": state.overruns,
    }


def _interface(interface: Interface) -> dict[str, str]:
    return {
        "port": interface.port,
        "instance": interface.instance,
        "interface": interface.name,
    }


def _ports(described: Description) -> Iterator[str]:
    for kind, ports in (("in", described.in_ports), ("out", described.out_ports)):
        for name, port in ports.items():
            yield f"{kind} {name}: {port.type}"
    for kind, found in (
        ("provides", described.providers),
        ("requires", described.consumers),
    ):
        for each in found:
            yield f"{kind} {each.port}.{each.instance}: {each.name}"


def _print(value: object) -> None:
    write_out(f"{json.dumps(value, indent=2, ensure_ascii=False)}\n")
