"""The command `rtgen log info`: what is in a recording."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import click

from rtgen.cli.common import OK, Console, with_console, write_out
from rtgen.cli.log.common import reported, source
from rtgen.cli.summary import table
from rtgen.recording.events import Log
from rtgen.recording.recorder import METADATA
from rtgen.runtime.timing.clocks import SECOND

_HEADER = ("event", "of", "type", "count", "from [s]", "to [s]")


@click.command("info")
@click.argument("file", type=click.Path(path_type=Path))
@with_console
def info_(console: Console, file: Path) -> int:
    """Tell what is in FILE: its form, and each source of events with count and times."""
    with reported():
        log = Log(file)
        counts: Counter[tuple[str, str]] = Counter()
        times: dict[tuple[str, str], tuple[int, int]] = {}
        types: dict[tuple[str, str], str] = {}
        for event in log.heads():
            key = event["event"], source(event)
            counts[key] += 1
            first, _ = times.get(key, (event["t"], 0))
            times[key] = first, event["t"]
            types[key] = event.get("type", "")
    rows = [
        (*key, types[key], str(count), *(f"{t / SECOND:.3f}" for t in times[key]))
        for key, count in counts.items()
    ]
    lines = [f"{file.name}: {_form(log)}", "", *table(_HEADER, rows, (0, 1, 2))]
    write_out("".join(f"{line}\n" for line in lines))
    return OK


def _form(log: Log) -> str:
    if log.mcap is None:
        return "JSON lines"
    clock = log.mcap.metadata.get(METADATA, {}).get("clock")
    time = f", {clock} time" if clock else ""
    cut = "" if log.mcap.is_whole else ", cut off"
    lost = f", {log.mcap.damaged} damaged chunks left out" if log.mcap.damaged else ""
    return f"MCAP{time}{cut}{lost}"
