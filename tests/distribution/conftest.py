"""Two systems of one network, each with what a process of its own would have."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack

import pytest
from distributed_system import Process

from rtgen.runtime.distribution.in_process import Network
from rtgen.runtime.distribution.medium import Medium


@pytest.fixture
def network() -> Network:
    return Network()


@pytest.fixture
def start(network: Network) -> Iterator[Callable[..., Process]]:
    """Starts further systems, on the media of the network unless one is given."""
    with ExitStack() as stack:

        def started(*instances: str, medium: Medium | None = None) -> Process:
            made = Process(medium or network.medium(), *instances)
            return stack.enter_context(made)

        yield started
