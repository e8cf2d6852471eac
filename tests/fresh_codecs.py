"""A conftest for mutation testing: each test compiles the codecs that it uses.

mutmut runs for a function the tests that have called it. What is compiled at first use would be
known of the first of its users alone.
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


def _noted_function(kind: str, descriptor: Any, format_: Any) -> Any:
    _codecs.append(descriptor.codecs)
    return _function(kind, descriptor, format_)


def _noted_method(self: Any, instance: object, owner: type[Any]) -> Any:
    found = _get(self, instance, owner)
    homes = (c for c in owner.__mro__ if self._kind in vars(c))
    _methods.append((next(homes), self))
    return found


compiler._function = _noted_function
cdr._Compiled.__get__ = _noted_method  # type: ignore[method-assign]


@pytest.fixture(autouse=True)
def fresh_codecs() -> None:
    """Forget what was compiled by the tests before."""
    for codecs in _codecs:
        codecs.clear()
    for home, method in _methods:
        setattr(home, method._kind, method)
    _codecs.clear()
    _methods.clear()
