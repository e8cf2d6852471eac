"""The command `rtgen rpc replay`: checks codecs against recorded calls."""

from __future__ import annotations

from pathlib import Path

import click

from rtgen.cli.help import command
from rtgen.cli.options import with_console
from rtgen.cli.rpc.common import with_representation
from rtgen.tools.kit.console import Console, write_text
from rtgen.tools.kit.exits import NO, OK, Refusal
from rtgen.tools.kit.json_text import parse_json
from rtgen.tools.rpc.recorded_calls import Replay
from rtgen.tools.rpc.signatures import Wire, content

_FORMAT = "opaque-rpc-trace/1"


@command("replay")
@click.argument("traces", type=click.Path(dir_okay=False, path_type=Path))
@click.option("--verbose", is_flag=True, help="Print each case.")
@with_representation
@with_console
def replay_(console: Console, traces: Path, verbose: bool, wire: Wire) -> int:
    """Compare recorded calls with newly generated codecs.

    The request and the reply of each case are encoded from values, and decoded to values, in the
    data representation of the case. Exit code 1: a case differs.
    """
    try:
        recorded = parse_json(content(traces))
    except (ValueError, RecursionError) as error:
        raise Refusal(f"{traces} is not JSON: {error}") from error
    if not isinstance(recorded, dict) or recorded.get("format") != _FORMAT:
        raise Refusal(f"{traces} is not a file of the format {_FORMAT}")
    replay = Replay(recorded, wire)
    try:
        cases = [*recorded["cases"], *recorded.get("shared_channel_cases", [])]
        results = [(case["id"], list(replay.differences(case))) for case in cases]
    except (KeyError, TypeError) as error:
        raise Refusal(f"{traces}: {type(error).__name__}: {error}") from error
    equal = sum(not differences for _, differences in results)
    lines = [f"{len(cases)} cases, {equal} equal"]
    for name, differences in results:
        if verbose and not differences:
            lines.append(f"{name}: equal")
        lines += [f"{name}: {difference}" for difference in differences]
    write_text("".join(f"{line}\n" for line in lines))
    return OK if equal == len(cases) else NO
