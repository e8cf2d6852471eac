"""Commands whose standard streams the caller has closed, as `rtgen check >&-` does."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
GOAL = "specs/navigation/rh3_goal.xml"

pytestmark = pytest.mark.skipif(os.name != "posix", reason="sh closes the streams")


def called(closed: str, *arguments: str) -> subprocess.CompletedProcess[str]:
    script = f'exec "$@" {closed}'
    command = ["sh", "-c", script, "sh", sys.executable, "-m", "rtgen", *arguments]
    return subprocess.run(
        command, cwd=ROOT, capture_output=True, text=True, check=False
    )


@pytest.mark.parametrize("closed", ["<&-", ">&-", "2>&-", "<&- >&- 2>&-"])
@pytest.mark.parametrize(
    "command", ["--version", "explain IDL0200", "explain", "inspect specs/tecs"]
)
def test_a_command_says_what_it_can(closed: str, command: str) -> None:
    usual, done = called("", *command.split()), called(closed, *command.split())
    assert done.returncode == usual.returncode == 0
    assert done.stdout == ("" if " >&-" in f" {closed}" else usual.stdout)
    assert done.stderr == ("" if "2>&-" in closed else usual.stderr)


@pytest.mark.nightly
def test_no_file_takes_the_place_of_a_stream(tmp_path: Path) -> None:
    drawn = []
    for number, closed in enumerate(["", "<&- >&- 2>&-"]):
        file = tmp_path / f"{number}.svg"
        assert called(closed, "graph", GOAL, "-o", str(file)).returncode == 0
        drawn.append(file.read_bytes())
    assert drawn[0] == drawn[1]
