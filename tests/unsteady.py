"""Runs the tests that failed once more, alone: `unsteady.py CODE CACHE`, after a run of pytest.

CODE is the exit code of the run and CACHE its cache. A machine that runs ten processes beside a
test can make one of thousands miss its time. A few tests that pass alone each time are reported,
and are no failure of the run; see docs/decisions/0034-unsteady-tests.md.
"""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
MOST = 3
"""Number of tests of a run that may be unsteady."""
TIMES = 3
"""How often each of them has to pass."""
FAILURES = 1
"""The exit code of pytest if tests failed; others tell that a run was not completed."""
NO_TESTS = 5
"""The exit code of pytest if it selects no test: a wing may have none that waits."""


def judge(
    code: int, cache: Path, python: str, environment: dict[str, str] | None = None
) -> int:
    """Return 0 if there are no tests or all that failed are unsteady, else the run's exit code.

    The tests are shown with the values of their assertions.
    """
    if code == NO_TESTS:
        return 0
    file = cache / "v" / "cache" / "lastfailed"
    failed = [*json.loads(file.read_text())] if file.exists() else []
    times = TIMES if code == FAILURES and 0 < len(failed) <= MOST else 1
    again = [
        python,
        "-m",
        "pytest",
        "-q",
        "-p",
        "no:cacheprovider",
        f"--maxfail={MOST}",
    ]
    for _ in range(times if failed else 0):
        command = [*again, *failed]
        if subprocess.run(command, cwd=ROOT, env=environment, check=False).returncode:
            return code
    if times != TIMES:
        return code
    for test in failed:
        print(f"UNSTEADY: {test} failed once, and passed {TIMES} times alone")
    return 0


if __name__ == "__main__":
    raise SystemExit(judge(int(sys.argv[1]), Path(sys.argv[2]), sys.executable))
