"""The command `rtgen log info`: what is in a recording."""

from __future__ import annotations

import json
from collections import Counter
from pathlib import Path
from typing import Any

import click

from rtgen.cli.help import command
from rtgen.cli.options import with_console
from rtgen.compiler.kit.translation import translated, translated_word
from rtgen.facts.columns import table
from rtgen.runtime.timing.clocks import SECOND
from rtgen.tools.kit.console import Console, write_out
from rtgen.tools.kit.exits import OK
from rtgen.tools.recording.bag_writer import PROFILE
from rtgen.tools.recording.events import Log
from rtgen.tools.recording.mcap_writer import METADATA
from rtgen.tools.recording.selection import reported, source

_FORMS = {"mcap": "MCAP"}
_HEADER = ("event", "of", "type", "count", "from [s]", "to [s]")


@command("info")
@click.argument("file", type=click.Path(path_type=Path))
@click.option("--json", "as_json", is_flag=True, help="Print JSON (rtgen-log/1).")
@with_console
def info_(console: Console, file: Path, as_json: bool) -> int:
    """Show the format of FILE, and each source of events with count and times."""
    with reported(file):
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
    if as_json:
        sources = [
            {
                "event": kind,
                "of": of,
                "type": types[kind, of],
                "count": count,
                "from": times[kind, of][0],
                "to": times[kind, of][1],
            }
            for (kind, of), count in counts.items()
        ]
        document = {"format": "rtgen-log/1", **_described(log), "sources": sources}
        write_out(f"{json.dumps(document, ensure_ascii=False, indent=2)}\n")
        return OK
    rows = [
        (*key, types[key], str(count), *(f"{t / SECOND:.3f}" for t in times[key]))
        for key, count in counts.items()
    ]
    cells = table([tuple(map(translated_word, _HEADER)), *rows], right=(3, 4, 5))
    lines = [f"{file.name}: {_form(log)}", "", *cells]
    write_out("".join(f"{line}\n" for line in lines))
    return OK


def _form(log: Log) -> str:
    described = _described(log)
    if log.recording is None:
        return ", ".join(map(translated, ["JSON lines", *log.losses()]))
    form = _FORMS.get(log.recording.form, log.recording.form)
    kind = ["a bag of ROS 2"] if log.recording.profile == PROFILE else []
    time = [f"{described['clock']} time"] if described["clock"] else []
    return ", ".join(map(translated, [form, *kind, *time, *log.losses()]))


def _described(log: Log) -> dict[str, Any]:
    """Return the form of a file, its clock if known, and how much of it was read."""
    if log.recording is None:
        return {
            "form": "json-lines",
            "clock": None,
            "whole": not log.losses(),
            "damaged": 0,
        }
    clock = log.recording.metadata.get(METADATA, {}).get("clock")
    return {
        "form": log.recording.form,
        "clock": clock,
        "whole": log.recording.is_whole,
        "damaged": log.recording.damaged,
    }
