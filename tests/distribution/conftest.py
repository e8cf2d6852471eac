"""Systems of one network, each with what a process of its own would have, over each medium."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack

import media
import pytest
from distributed_system import Process

from rtgen.runtime.distribution.medium import Medium


@pytest.fixture(params=media.ENGINES)
def network(request: pytest.FixtureRequest) -> Iterator[media.Engine]:
    with media.engine(request.param) as engine:
        yield engine


@pytest.fixture
def start(network: media.Engine) -> Iterator[Callable[..., Process]]:
    """Starts further systems, on the media of the network unless one is given."""
    with ExitStack() as stack:

        def started(*instances: str, medium: Medium | None = None) -> Process:
            made = Process(medium or network.medium(), *instances)
            return stack.enter_context(made)

        yield started
