"""Steps of starting a system on OpenRTM, with the reasons of failures."""

from __future__ import annotations

from typing import Any


class StartError(Exception):
    """The reason why a system does not start."""


class Step:
    """The current step: prefixes its text to CORBA exceptions and StartErrors."""

    def __init__(self, text: str) -> None:
        self._text = text

    def __enter__(self) -> None:
        return None

    def __exit__(self, kind: type[BaseException] | None, error: Any, _: object) -> None:
        if kind is not None and issubclass(kind, Exception):
            raise StartError(f"{self._text}: {error_text(error)}") from None


def error_text(error: BaseException) -> str:
    if isinstance(error, StartError):
        return str(error)
    return f"{type(error).__name__}: {error}"
