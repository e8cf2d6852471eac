"""Commands whose answers are stored."""

from __future__ import annotations

import functools
import sys
from collections.abc import Callable
from typing import Any

import click

_NOT_REPEATED = ("no_cache", "verbose", "fix")
"""Parameters with which an answer is not stored: with the last two it is another each time."""


def with_answer(function: Callable[..., int]) -> Callable[..., int]:
    """Store the answer of a command, which is repeated while nothing changes; place it first."""

    @functools.wraps(function)
    def wrapped(**kwargs: Any) -> int:
        is_of_process = click.get_current_context().find_root().obj
        if not is_of_process or any(map(kwargs.get, _NOT_REPEATED)):
            return function(**kwargs)
        from rtgen.tools.kit.answering import answered

        return answered(sys.argv[1:], lambda: function(**kwargs))

    return wrapped
