"""Writes files that a command names."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path

from rtgen.compiler.diagnostics import ToolError
from rtgen.facts.files import create_file, make_folder, real_path
from rtgen.tools.kit.exits import Refusal


def save(path: Path, octets: bytes) -> None:
    """Create or replace a file. Raises ToolError if that fails."""
    try:
        with create_file(path) as stream:
            stream.write(octets)
    except OSError as error:
        raise ToolError(f"cannot write {path}: {error.strerror}") from error


def require_different(outputs: Mapping[str, str | None], *inputs: str | Path) -> None:
    """Raise Refusal if two options name the same output, or one names an input."""
    users: dict[str, str] = {}
    read = {real_path(os.fspath(file)) for file in inputs}
    for option, file in outputs.items():
        if file is None or _is_device(file):
            continue  # such as /dev/null
        path = real_path(file)
        if path in read:
            raise Refusal(f"{option} would overwrite {file}, which is read")
        other = users.setdefault(path, option)
        if other != option:
            raise Refusal(f"{other} and {option} both write {file}")


def _is_device(file: str) -> bool:
    try:
        return Path(file).is_char_device()
    except OSError:  # such as a loop of links
        return False


def results_of(name: str) -> Path:
    """Return the folder for results of a run, made if missing. Raises ToolError."""
    results = Path("build") / name
    try:
        make_folder(results)
    except OSError as error:
        raise ToolError(f"cannot make {results}: {error.strerror}") from error
    return results


def values_file(name: str, suffix: str) -> Path:
    """Return the default file for values of a run, in its folder. Raises ToolError."""
    return results_of(name) / f"values{suffix}"
