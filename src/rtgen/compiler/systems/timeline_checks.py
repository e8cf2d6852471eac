"""Checks of the timelines beside systems, without a run."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path

from rtgen.compiler.diagnostics import Diagnostic, InputError
from rtgen.compiler.model import System
from rtgen.compiler.systems.reading import read_file
from rtgen.compiler.systems.rules import SKIPPED
from rtgen.compiler.systems.timeline import Connect, Disconnect, Step, load

_SYSTEM = "system.xml"
_TIMELINE = "timeline.toml"


def findings(systems: Iterable[Path], encoding: str = "auto") -> Iterator[Diagnostic]:
    """Yield the diagnostics of the timelines that runs of systems carry out by default.

    That is the `timeline.toml` in the folder of a `system.xml`. A system with errors is left out.
    """
    for path in systems:
        file = path.parent / _TIMELINE
        if path.name != _SYSTEM or not file.is_file():
            continue
        system, _, _ = read_file(path, encoding)
        if system is None:
            continue
        try:
            plan = load(file, system)
        except InputError as error:
            yield from error.diagnostics
        else:
            yield from plan.skipped
            yield from _in_vain(plan.steps, system)


def _in_vain(steps: Iterable[Step], system: System) -> Iterator[Diagnostic]:
    """Yield a diagnostic for each event that its predecessors leave nothing to do."""
    present = {connection.name for connection in system.connections}
    for step in steps:
        match step.action:
            case Connect(name=name):
                if name in present:
                    yield _skipped(step, f"the connection {name!r} exists already")
                present.add(name)
            case Disconnect(name=name, others=others):
                cut = next((each for each in (name, *others) if each in present), None)
                if cut is None:
                    yield _skipped(step, f"no connection {name!r} at that time")
                else:
                    present.remove(cut)


def _skipped(step: Step, message: str) -> Diagnostic:
    return SKIPPED.at(step.span, f"{message}: the event is skipped")
