"""Runs the conformance suite over every engine."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack

import media
import pytest

from rtgen.runtime.distribution.medium import Medium


@pytest.fixture(params=media.ENGINES)
def engine(request: pytest.FixtureRequest) -> Iterator[media.Engine]:
    with media.engine(request.param, media.LEASE) as made:
        yield made


@pytest.fixture
def join(engine: media.Engine) -> Iterator[Callable[..., Medium]]:
    """Return a function that creates media of one network, which are closed at the end."""
    with ExitStack() as stack:

        def made(system: str = media.SYSTEM) -> Medium:
            medium = engine.medium(system)
            stack.callback(medium.close)
            return medium

        yield made
