"""Writes files that a command names."""

from __future__ import annotations

from pathlib import Path

from rtgen.compiler.diagnostics import ToolError
from rtgen.facts.files import create_file


def save(path: Path, octets: bytes) -> None:
    """Create or replace a file. Raises ToolError if that fails."""
    try:
        with create_file(path) as stream:
            stream.write(octets)
    except OSError as error:
        raise ToolError(f"cannot write {path}: {error.strerror}") from error
