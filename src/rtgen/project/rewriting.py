"""Atomically replaces files of the user, following links and keeping permissions."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

from rtgen.diagnostics import ToolError
from rtgen.project.loading import shown


def rewrite(path: Path, data: bytes) -> None:
    """Replace the content of a file, or of a link's target. Raises ToolError."""
    try:
        target = path.resolve(strict=True)
        temporary = target.with_name(f".{target.name}.{os.getpid()}.rtgen")
        try:
            with temporary.open("xb") as stream:
                stream.write(data)
            shutil.copymode(target, temporary)
            temporary.replace(target)
        except BaseException:
            temporary.unlink(missing_ok=True)
            raise
    except OSError as error:
        message = f"cannot write {shown(path)}: {error.strerror or error}"
        raise ToolError(message) from error
