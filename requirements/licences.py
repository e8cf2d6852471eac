"""Prints the licences of what rtgen requires directly, and of what its page contains, as Markdown.

pip-licenses reads what the installed packages state; a package that is not installed is an error.
"""

from __future__ import annotations

import json
import re
import subprocess
import sys
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import page

ROOT = Path(__file__).resolve().parent.parent
NAME = re.compile(r"[\w.-]+")
OWN = re.compile(r"rtgen-(?:runtime|speed)(?:\[(\w+)\])?==")
WORKSHOP = ("test", "check", "bench", "release")
"""The extras of those who change rtgen; users install none of them."""

HEAD = """# Licences of requirements

rtgen is under Apache-2.0. It contains none of the packages of this table: they are installed beside
it, those of extras where asked for. What a package states covers its own code, not always the
libraries that its wheel brings (omniORB, SDL): read theirs before you pass them on.
`make licences` makes this page of what the packages state.

| extra | package | licence |
|---|---|---|
"""

PAGE = """
The page of `rtgen ui`, in rtgen's wheel, is built from these npm packages. The wheel has the texts
of their licences in `rtgen/ui/page/licenses.md`.

| package | version | licence |
|---|---|---|
"""


def required() -> dict[str, list[str]]:
    """The names of the required packages by extra, `""` for those of rtgen itself."""
    project, runtime = (_project(folder) for folder in (ROOT, ROOT / "runtime"))
    groups = {"": project["dependencies"], **project["optional-dependencies"]}
    extras = runtime["optional-dependencies"]
    return {
        extra: [*dict.fromkeys(_names(needs, extras))]
        for extra, needs in groups.items()
        if extra not in (*WORKSHOP, "all")
    }


def _project(folder: Path) -> dict[str, Any]:
    text = (folder / "pyproject.toml").read_text("utf-8")
    project: dict[str, Any] = tomllib.loads(text)["project"]
    return project


def _names(needs: Sequence[str], extras: Mapping[str, Sequence[str]]) -> Iterator[str]:
    """Yield the names of requirements; for an extra of the runtime, those of that extra."""
    for need in needs:
        if own := OWN.match(need):
            yield from _names(extras[own[1]], extras) if own[1] else ()
        elif name := NAME.match(need):
            yield name[0]


def main() -> int:
    """Exit code 1 if a package is not installed."""
    groups = required()
    names = sorted({name for group in groups.values() for name in group})
    command = [sys.executable, "-m", "piplicenses", "--format", "json", "--from=all"]
    answer = subprocess.run(
        [*command, "--packages", *names], check=True, capture_output=True, text=True
    )
    stated = {entry["Name"].lower(): entry for entry in json.loads(answer.stdout)}
    lines = []
    for extra, group in groups.items():
        for name in group:
            entry = stated.get(name.lower())
            if entry is None:
                print(f"{name} is not installed", file=sys.stderr)
                return 1
            lines.append(f"| {extra or '(always)'} | {name} | {licence(entry)} |")
    contained = [f"| {' | '.join(package)} |" for package in page.packages()]
    sys.stdout.write(HEAD + "\n".join(lines) + "\n")
    sys.stdout.write(PAGE + "\n".join(contained) + "\n")
    return 0


def licence(entry: dict[str, str]) -> str:
    """The SPDX expression that a package states, else its classifier, else its metadata."""
    fields = ("License-Expression", "License-Classifier", "License-Metadata")
    stated = (entry.get(field, "UNKNOWN") for field in fields)
    found = next((text for text in stated if text != "UNKNOWN"), "UNKNOWN")
    return found.splitlines()[0].replace("|", "/")


if __name__ == "__main__":
    raise SystemExit(main())
