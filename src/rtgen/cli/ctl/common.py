"""Options and helpers of `rtgen ctl`: the system, and access to its components."""

from __future__ import annotations

import functools
import json
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from rtgen import runtime
from rtgen.cli.help import grouped
from rtgen.cli.options import with_console
from rtgen.cli.parameter_types import FiniteRange
from rtgen.cli.run_table import GIVEN, with_run_table
from rtgen.cli.transport_options import ENGINE_OPTIONS, PROCESSES
from rtgen.compiler.diagnostics import InputError, ToolError, has_errors
from rtgen.tools.kit.console import Console, write_out
from rtgen.tools.kit.exits import BAD_INPUT, NO, ReportedError
from rtgen.tools.kit.signals import terminable
from rtgen.tools.running import engines
from rtgen.tools.running.engines import EngineOptions

if TYPE_CHECKING:
    from rtgen.compiler.model import System
    from rtgen.runtime.distribution.control import Asker
    from rtgen.runtime.distribution.peers import Peers

_SETTLED = 0.3
"""Seconds without a further component after which the list counts as complete."""
_POLL_INTERVAL = 0.05


class Refused(click.ClickException):
    """A component rejected a request."""

    exit_code = NO


@dataclass(frozen=True, slots=True)
class CtlOptions(EngineOptions):
    """The system, and the time-out of looking for its components."""

    system: str | None = None
    wait: float = 2.0


_OPTIONS = (
    click.option(
        "--transport",
        type=click.Choice([*engines.TAKES]),
        help="Transport of the processes; default: that of [run].",
    ),
    click.option(
        "--system",
        type=click.Path(),
        metavar="FILE",
        help="The system, or its folder; its name is the partition.",
    ),
    *ENGINE_OPTIONS,
    click.option(
        "--wait",
        type=FiniteRange(0, 86400),
        default=2.0,
        metavar="SECONDS",
        help="For components and states; default: 2.",
    ),
)


with_json = click.option("--json", "as_json", is_flag=True, help="Print JSON.")


def with_system(command: Callable[..., int]) -> Callable[..., int]:
    """Add the options that name a system; the function gets them as `options`."""

    @with_console
    @with_run_table(system="system", transport="transport", partition="partition")
    @grouped(PROCESSES, *_OPTIONS)
    @functools.wraps(command)
    def wrapped(console: Console, **kwargs: Any) -> int:
        options = CtlOptions(**{f.name: kwargs.pop(f.name) for f in fields(CtlOptions)})
        if options.transport not in engines.TAKES:
            raise click.UsageError(
                "Missing option '--transport', dds or zenoh, and `[run] transport` in rtgen.toml."
            )
        source = click.get_current_context().get_parameter_source
        if source("partition") in GIVEN and source("system") not in GIVEN:
            options = replace(options, system=None)
        return command(console, options=options, **kwargs)

    return wrapped


@contextmanager
def joined(
    console: Console, options: CtlOptions, profile: System | None = None
) -> Iterator[Peers]:
    """Join the system, to access its components. Raises ToolError, Refused, ReportedError.

    `profile` is the result of `profile_of`, if that was called. Ctrl-C and SIGTERM raise
    KeyboardInterrupt.
    """
    from rtgen.runtime.distribution.control import ControlError, RefusedError

    options.check_taken(
        {name: names | {"system", "wait"} for name, names in engines.TAKES.items()}
    )
    partition = options.partition
    if not partition:
        named = profile or profile_of(console, options)
        if named is None:
            raise click.UsageError(
                "which system? Give --system FILE or --partition NAME."
            )
        partition = named.name
    with terminable(), options.open(partition) as transport:
        transport.peers.listeners.clear()
        try:
            yield transport.peers
        except RefusedError as error:
            raise Refused(str(error)) from error
        except (ControlError, runtime.TransportError) as error:
            raise ToolError(str(error)) from error


def profile_of(console: Console, options: CtlOptions) -> System | None:
    """Return the system of `--system`; its name is the partition of its processes."""
    if options.system is None:
        return None
    from rtgen.compiler.systems.reading import read_file

    path = Path(options.system)
    profile, diagnostics, sources = read_file(
        path / "system.xml" if path.is_dir() else path
    )
    console.findings(diagnostics, sources)
    if profile is None or has_errors(diagnostics):
        raise ReportedError(BAD_INPUT)
    return profile


def judged_profile_of(console: Console, options: CtlOptions) -> System | None:
    """Return `profile_of`, and report connections whose ends do not fit; it may run even so."""
    profile = profile_of(console, options)
    if profile is not None:
        from rtgen.compiler.judging import Judge
        from rtgen.compiler.project import cache, load_around
        from rtgen.compiler.systems import timeline
        from rtgen.tools.running.plan import is_fitting

        judge = Judge(load_around(Path(profile.file)), cache.default())
        steps: Sequence[timeline.Step] = ()
        try:
            path = Path(options.system or "")
            steps = timeline.of_system(path, None, profile).steps
        except InputError as error:
            console.findings(error.diagnostics)
        is_fitting(judge, profile, steps, console)
    return profile


def asker(peers: Peers, instance: str, options: CtlOptions) -> Asker:
    """Return the component of that name. Raises ToolError if no process has it."""
    deadline = time.monotonic() + options.wait
    while not peers.is_present(instance):
        if time.monotonic() > deadline:
            names = ", ".join(peers.instances) or "none"
            raise ToolError(
                f"no process has {instance}; known: {names}",
                hint="the processes need the same --transport, and the same --partition or system",
            )
        peers.wait(_POLL_INTERVAL)
    return peers.asker(instance)


def settled(peers: Peers, options: CtlOptions) -> Sequence[str]:
    """Return the components of all processes, once no further one is found."""
    begun = changed = time.monotonic()
    instances = peers.instances
    while True:
        peers.wait(_POLL_INTERVAL)
        now = time.monotonic()
        if peers.instances != instances:
            instances, changed = peers.instances, now
        if now - begun >= options.wait or (instances and now - changed >= _SETTLED):
            return instances


def print_json(value: object) -> None:
    """Print a value as indented JSON."""
    write_out(f"{json.dumps(value, indent=2, ensure_ascii=False)}\n")
