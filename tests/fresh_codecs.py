"""A conftest for mutation testing: each test compiles the codecs that it uses.

For a mutant of a function, mutmut runs the tests that called the function. Without this module,
only the first test that uses a codec would call the compiler.
"""

from __future__ import annotations

from typing import Any

import pytest

from rtgen.runtime import cdr
from rtgen.runtime.marshalling import compiler

_function = compiler._function
_get = cdr._Compiled.__get__
_codecs: list[dict[Any, Any]] = []
_methods: list[tuple[type[Any], cdr._Compiled]] = []


def _recording_function(kind: str, descriptor: Any, format_: Any) -> Any:
    _codecs.append(descriptor.codecs)
    return _function(kind, descriptor, format_)


def _recording_method(self: Any, instance: object, owner: type[Any]) -> Any:
    found = _get(self, instance, owner)
    homes = (c for c in owner.__mro__ if self._kind in vars(c))
    _methods.append((next(homes), self))
    return found


compiler._function = _recording_function
cdr._Compiled.__get__ = _recording_method  # type: ignore[method-assign]


@pytest.fixture(autouse=True)
def fresh_codecs() -> None:
    """Discard the codecs that earlier tests compiled."""
    for codecs in _codecs:
        codecs.clear()
    for home, method in _methods:
        setattr(home, method._kind, method)
    _codecs.clear()
    _methods.clear()
