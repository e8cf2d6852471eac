"""The command `rtgen log export`: a recording as a bag of ROS 2."""

from __future__ import annotations

from pathlib import Path

import click

from rtgen.cli.help import command
from rtgen.cli.options import with_console
from rtgen.compiler.project import load_around
from rtgen.tools.kit.console import Console
from rtgen.tools.kit.exits import OK, Refusal
from rtgen.tools.recording.bag_export import export, summary
from rtgen.tools.recording.bag_files import open_recording
from rtgen.tools.recording.errors import RecordingError
from rtgen.tools.recording.selection import reported, say_losses


@command("export")
@click.argument("file", type=click.Path(path_type=Path))
@click.argument("folder", type=click.Path(path_type=Path))
@click.option("--ros2", "is_bag", is_flag=True, help="Write a bag of ROS 2.")
@with_console
def export_(console: Console, file: Path, folder: Path, is_bag: bool) -> int:
    """Write the samples of FILE as a bag of ROS 2: FOLDER, which must not exist.

    The topics are those of [ros2.topics] of the project: of an OutPort, or of InPorts that it was
    connected to. Other ports with messages of ROS 2 have topics /INSTANCE/PORT. What is not a
    message is left out.
    """
    if not is_bag:
        raise Refusal("--ros2 is missing: it is the only form of an export")
    settings = load_around(file).ros2
    with reported(file):
        recorded = open_recording(file)
        if recorded is None:
            raise RecordingError(
                f"{file} is not an MCAP file, and no bag of ROS 2",
                hint="`rtgen run --record FILE.mcap` writes one; lines of JSON have no types",
            )
        done = export(recorded, settings, folder)
    say_losses(console, recorded)
    for line in summary(done):
        console.say(f"{folder}: {line}")
    return OK
