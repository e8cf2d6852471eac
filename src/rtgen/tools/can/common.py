"""Helpers shared by the commands of `rtgen can`."""

from __future__ import annotations

from rtgen.compiler.diagnostics import ToolError
from rtgen.facts.extras import installation


def require_python_can() -> None:
    """Raises ToolError unless python-can is installed."""
    try:
        import can  # noqa: F401
    except ImportError as error:
        raise ToolError(
            "this command needs the package python-can, which is not installed",
            hint=installation("can"),
        ) from error


def counted(number: int, what: str) -> str:
    """Return a count with its noun, such as "1 frame" or "2 frames"."""
    return f"{number} {what}" if number == 1 else f"{number} {what}s"
