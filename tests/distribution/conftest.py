"""Systems of one network, each with what a process of its own would have, over each medium."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from typing import Any

import pytest
from distributed_system import Process

from rtgen.runtime.distribution.in_process import Network
from rtgen.runtime.distribution.medium import Medium

DOMAIN = 90


class DdsNetwork:
    """Participants of this process in a partition of their own."""

    def __init__(self) -> None:
        self._partition = f"test-{os.urandom(8).hex()}"

    def medium(self) -> Medium:
        """One more process's part."""
        from rtgen.runtime.dds.medium import DdsMedium

        return DdsMedium(self._partition, domain=DOMAIN)


@pytest.fixture(params=["in-process", "dds"])
def network(request: pytest.FixtureRequest) -> Any:
    if request.param == "in-process":
        return Network()
    pytest.importorskip("cyclonedds", reason="cyclonedds is not installed")
    return DdsNetwork()


@pytest.fixture
def start(network: Any) -> Iterator[Callable[..., Process]]:
    """Starts further systems, on the media of the network unless one is given."""
    with ExitStack() as stack:

        def started(*instances: str, medium: Medium | None = None) -> Process:
            made = Process(medium or network.medium(), *instances)
            return stack.enter_context(made)

        yield started
