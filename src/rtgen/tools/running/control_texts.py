"""What rtgen ctl prints of components, as text and as JSON."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from rtgen.compiler.kit.translation import translated_word

if TYPE_CHECKING:
    from rtgen.runtime.distribution.control import State
    from rtgen.runtime.distribution.descriptions import Description, Interface


def condition_text(instances: Sequence[str], states: Mapping[str, State]) -> str:
    """Return the condition of a system, in the words of `rtgen run --supervise`."""
    lost = ", ".join(name for name in instances if name not in states)
    failed = ", ".join(
        name
        for name in instances
        if name in states and state_name(states[name]) == "ERROR"
    )
    parts = [f"without {lost}"] * bool(lost) + [f"{failed} in ERROR"] * bool(failed)
    return ", ".join(["degraded", *parts]) if parts else "complete"


def state_name(state: State) -> str:
    return state.state.removesuffix("_STATE")


def state_text(state: State | None) -> str:
    if state is None:
        return "lost"
    return (
        f"{state_name(state)} ({state.reason})" if state.reason else state_name(state)
    )


def state_row(instance: str, state: State) -> tuple[str, ...]:
    """Return the cells of a table, in the language."""
    text = translated_word(state_text(state))
    return instance, text, str(state.ticks), str(state.overruns)


def state_json(instance: str, state: State | None) -> dict[str, Any]:
    if state is None:
        return {"instance": instance, "state": None}
    return {
        "instance": instance,
        "state": state_name(state),
        "reason": state.reason,
        "ticks": state.ticks,
        "overruns": state.overruns,
    }


def description_json(described: Description) -> dict[str, Any]:
    return {
        "type": described.type,
        "in_ports": {n: p.type for n, p in described.in_ports.items()},
        "out_ports": {n: p.type for n, p in described.out_ports.items()},
        "providers": [_interface_json(each) for each in described.providers],
        "consumers": [_interface_json(each) for each in described.consumers],
    }


def _interface_json(interface: Interface) -> dict[str, str]:
    return {
        "port": interface.port,
        "instance": interface.instance,
        "interface": interface.name,
    }


def units(described: Description) -> dict[str, str]:
    """Return the units of the parameters that have one."""
    return {p.name: p.unit for p in described.parameters if p.unit}


def value_line(name: str, value: str, unit: str | None) -> str:
    """Return the value of a parameter with its unit, as `inspect` writes it."""
    return f"{name} = {value} [{unit}]" if unit else f"{name} = {value}"


def port_lines(described: Description) -> Iterator[str]:
    """Yield the ports and services of a component, in the language."""
    for kind, ports in (("in", described.in_ports), ("out", described.out_ports)):
        for name, port in ports.items():
            yield f"{translated_word(kind)} {name}: {port.type}"
    for kind, interfaces in (
        ("provides", described.providers),
        ("requires", described.consumers),
    ):
        for each in interfaces:
            yield f"{translated_word(kind)} {each.port}.{each.instance}: {each.name}"
            if kind == "provides":
                yield from (f"  {operation}" for operation in each.operations)
