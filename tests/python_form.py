"""Checks that Python files are formatted by black: `python tests/python_form.py FOLDER_OR_FILE...`

Ruff's formatter is thirty times as fast as black, and differs from black in a few constructs: files
that ruff would leave unchanged are in the form, files that ruff would change are checked by black.
"""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Sequence

RUFF = ("-m", "ruff", "format", "--check", "--isolated", "--no-cache")
LIKE_BLACK = ("--line-length=88", "--target-version=py311", "--exclude=*.md")
"""Black's line length in pyproject.toml; black does not format Python in Markdown."""


def doubtful(paths: Sequence[str]) -> list[str]:
    """Return the files that ruff's formatter would change or cannot read.

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
    """Return 0 if all files are formatted, else black's exit code; black prints their names."""
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
