"""Loggers of components, `Component.logger`."""

from __future__ import annotations

import logging
from collections.abc import Callable
from typing import Final

from rtgen.runtime.timing.traffic import LogLine

LOGGERS: Final = "rtgen.components"
"""Name of the logger above those of all components, whose names are `rtgen.components.INSTANCE`."""
_LONGEST: Final = 10_000
"""Maximum number of characters of a line that is reported."""
_FORM: Final = logging.Formatter("%(message)s")


def logger_of(instance: str, report: Callable[[LogLine], None]) -> logging.Logger:
    """Return a new logger, whose lines are reported, too.

    It is not known by its name, since several systems of a process may have the instance.
    """
    logger = logging.Logger(f"{LOGGERS}.{instance}")
    logger.parent = logging.getLogger(LOGGERS)
    logger.addHandler(_Reporting(instance, report))
    return logger


def instance_of(record: logging.LogRecord) -> str:
    """Return the instance whose logger has made a record; empty for others."""
    prefix, _, instance = record.name.partition(f"{LOGGERS}.")
    return instance if not prefix else ""


class _Reporting(logging.Handler):
    def __init__(self, instance: str, report: Callable[[LogLine], None]) -> None:
        super().__init__()
        self._instance = instance
        self._report = report

    def emit(self, record: logging.LogRecord) -> None:
        try:
            text = _FORM.format(record).replace("\0", "")
            text = text.encode("utf-8", "replace").decode()
            if len(text) > _LONGEST:
                text = f"{text[:_LONGEST]}..."
            line = LogLine(
                self._instance,
                record.levelno,
                text,
                record.pathname,
                record.funcName or "",
                record.lineno,
            )
            self._report(line)
        except Exception:
            self.handleError(record)
