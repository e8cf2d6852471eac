"""Systems of one network, each like a separate process, over each medium."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack

import media
import pytest
from distributed_system import Process

from rtgen.runtime.distribution.medium import Medium


class _Closing:
    """An engine whose media end with the test."""

    def __init__(self, engine: media.Engine, stack: ExitStack) -> None:
        self._engine = engine
        self._stack = stack
        self.address = engine.address

    def medium(self, system: str = media.SYSTEM) -> Medium:
        made = self._engine.medium(system)
        self._stack.callback(made.close)
        return made


@pytest.fixture(params=media.ENGINES)
def network(request: pytest.FixtureRequest) -> Iterator[media.Engine]:
    with media.engine(request.param) as engine, ExitStack() as stack:
        yield _Closing(engine, stack)


@pytest.fixture
def start(network: media.Engine) -> Iterator[Callable[..., Process]]:
    """Return a function that starts further systems, by default on the network's media."""
    with ExitStack() as stack:

        def started(*instances: str, medium: Medium | None = None) -> Process:
            made = Process(medium or network.medium(), *instances)
            return stack.enter_context(made)

        yield started
