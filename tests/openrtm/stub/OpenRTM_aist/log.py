"""The log of a manager: a file, or standard output."""

from __future__ import annotations

import logging
import os
import sys
from typing import Any

from .properties import Properties
from .values import toBool

LEVELS = {
    "SILENT": logging.CRITICAL + 1,
    "FATAL": logging.CRITICAL,
    "ERROR": logging.ERROR,
    "WARN": logging.WARNING,
    "INFO": logging.INFO,
    "DEBUG": logging.DEBUG,
    "TRACE": logging.DEBUG,
    "VERBOSE": logging.DEBUG,
    "PARANOID": logging.DEBUG,
}


class Logger:
    """The logger of components."""

    def __init__(self, name: str) -> None:
        self._log = logging.getLogger(f"openrtm.{name}")

    def RTC_FATAL(self, text: str, values: Any = ()) -> None:
        self._write(logging.CRITICAL, text, values)

    def RTC_ERROR(self, text: str, values: Any = ()) -> None:
        self._write(logging.ERROR, text, values)

    def RTC_WARN(self, text: str, values: Any = ()) -> None:
        self._write(logging.WARNING, text, values)

    def RTC_INFO(self, text: str, values: Any = ()) -> None:
        self._write(logging.INFO, text, values)

    def RTC_DEBUG(self, text: str, values: Any = ()) -> None:
        self._write(logging.DEBUG, text, values)

    def RTC_TRACE(self, text: str, values: Any = ()) -> None:
        self._write(logging.DEBUG, text, values)

    def _write(self, level: int, text: str, values: Any) -> None:
        given = values if isinstance(values, tuple) else (values,)
        self._log.log(level, text % given if values != () else text)


def begin(config: Properties) -> logging.Handler | None:
    """Return the handler that the configuration selects; None for none."""
    if not toBool(config.getProperty("logger.enable"), "YES", "NO", True):
        return None
    name = config.getProperty("logger.file_name", "./rtc%p.log")
    handler: logging.Handler
    if name == "stdout":
        handler = logging.StreamHandler(sys.stdout)
    else:
        handler = logging.FileHandler(name.replace("%p", str(os.getpid())))
    level = LEVELS.get(config.getProperty("logger.log_level", "INFO"), logging.INFO)
    handler.setLevel(level)
    log = logging.getLogger("openrtm")
    log.setLevel(logging.DEBUG)
    log.addHandler(handler)
    return handler


def end(handler: logging.Handler | None) -> None:
    if handler is not None:
        logging.getLogger("openrtm").removeHandler(handler)
        handler.close()
