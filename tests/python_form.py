"""Whether Python files are in black's form: `python tests/python_form.py FOLDER_OR_FILE...`

Ruff's formatter is thirty times as fast as black, and differs from black in a few constructs: what
ruff would leave is in the form, what ruff would change is judged by black.
"""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Sequence

RUFF = ("-m", "ruff", "format", "--check", "--isolated", "--no-cache")
LIKE_BLACK = ("--line-length=88", "--target-version=py311", "--exclude=*.md")
"""Black's line length in pyproject.toml; Python in Markdown is not looked at by black."""


def doubtful(paths: Sequence[str]) -> list[str]:
    """The files that ruff's formatter would change or cannot read.

    Raises RuntimeError with ruff's message if ruff does not run.
    """
    command = [sys.executable, *RUFF, *LIKE_BLACK, "--output-format=json", *paths]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    try:
        findings = json.loads(done.stdout)
    except ValueError:
        raise RuntimeError(done.stderr) from None
    if not findings and done.returncode != 0:
        raise RuntimeError(done.stderr)
    return sorted({finding["filename"] for finding in findings})


def main(paths: Sequence[str]) -> int:
    """Exit code 0 if all files are in the form, else black's, which names those that are not."""
    files = doubtful(paths)
    if not files:
        return 0
    command = [sys.executable, "-m", "black", "--check", *files]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        print(done.stderr, file=sys.stderr)
    return done.returncode


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
