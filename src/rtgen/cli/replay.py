"""The command `rtgen replay`: plays a recorded run, into a system or to standard output."""

from __future__ import annotations

from pathlib import Path

import click

from rtgen.cli.help import command
from rtgen.cli.options import with_console
from rtgen.cli.run_table import with_run_table
from rtgen.cli.running_options import (
    RATE,
    with_end_of_replay,
    with_failures,
    with_recording,
    with_value_checks,
)
from rtgen.tools.kit.console import Console
from rtgen.tools.kit.exits import Refusal
from rtgen.tools.running.failures import FailureOptions
from rtgen.tools.running.recording_options import RecordingOptions
from rtgen.tools.running.replaying import ReplayOptions, printed, replayed


@command()
@with_console
@with_run_table(system="into")
@click.argument("file", type=click.Path(path_type=Path))
@click.option(
    "--into",
    metavar="SYSTEM",
    help="Run components of this system; default: that of [run].",
)
@click.option(
    "--only", metavar="INSTANCE,...", help="Run only these components of the system."
)
@click.option(
    "--rate",
    type=RATE,
    metavar="FACTOR",
    help="Speed factor; default: as fast as possible.",
)
@with_end_of_replay
@click.option(
    "--set",
    "settings",
    multiple=True,
    metavar="INSTANCE.PARAMETER=VALUE",
    help="Set a configuration parameter.",
)
@click.option(
    "--log", metavar="FILE", help="Write state changes and samples as JSON lines."
)
@with_value_checks
@with_recording
@with_failures
def replay(
    console: Console,
    file: Path,
    into: str | None,
    only: str | None,
    rate: float | None,
    until: float | None,
    settings: tuple[str, ...],
    log: str | None,
    check_values: str,
    recording: RecordingOptions,
    shown_failures: FailureOptions,
) -> int:
    """Replay a run that `rtgen run --record` has recorded, or a bag of ROS 2, in simulated time.

    With --into, the components of SYSTEM run, and the recorded samples of the other components
    reach their InPorts over the recorded connections; the messages of a bag reach those that
    [ros2.topics] binds to its topics. The initial states, parameters and timeline
    of the components are those of SYSTEM. Exit code 1: a component ended in ERROR, or its code
    raised an exception.
    """
    if into is None:
        if only or settings or log or recording.file:
            raise Refusal("--only, --set, --log and --record go with --into")
        return printed(console, file, rate, until)
    options = ReplayOptions(
        system=into,
        only=only,
        rate=rate,
        until=until,
        settings=settings,
        log=log,
        check_values=check_values,
        recording=recording,
        shown_failures=shown_failures,
    )
    return replayed(file, options, console)
