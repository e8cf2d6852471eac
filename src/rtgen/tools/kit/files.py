"""Writes files that a command names."""

from __future__ import annotations

from pathlib import Path

from rtgen.compiler.diagnostics import ToolError
from rtgen.facts.files import create_file, make_folder


def save(path: Path, octets: bytes) -> None:
    """Create or replace a file. Raises ToolError if that fails."""
    try:
        with create_file(path) as stream:
            stream.write(octets)
    except OSError as error:
        raise ToolError(f"cannot write {path}: {error.strerror}") from error


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
