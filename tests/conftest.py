"""Options of the whole test suite."""

from __future__ import annotations

import os
import signal
from pathlib import Path

import pytest
from hypothesis import settings

# How long an example takes is the machine's matter.
settings.register_profile("rtgen", deadline=None)
settings.load_profile("rtgen")

# Which bus python-can takes without being told: no test may get at a real one.
for _variable in ("CAN_INTERFACE", "CAN_CHANNEL", "CAN_BITRATE", "CAN_CONFIG"):
    os.environ.pop(_variable, None)

# In the background Ctrl-C is ignored, also by the processes that tests start and interrupt.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

TESTS = Path(__file__).parent
RANDOM = {"fuzz", "test_random_types_omniorb.py"}
"""Folders and files of tests with thousands of drawn inputs."""


def pytest_addoption(parser: pytest.Parser) -> None:
    """One flag renews every golden file; the diff is then for a reviewer."""
    parser.addoption(
        "--update-golden",
        action="store_true",
        help="Write golden files instead of comparing.",
    )


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Repetition covers nothing more: what is random or slow runs without being traced.

    OpenRTM's manager is the process's until its end, with an ORB and loggers that keep their
    settings, so its tests come last.
    """
    items.sort(key=lambda item: "openrtm" in item.path.relative_to(TESTS).parts[:1])
    for item in items:
        if item.get_closest_marker("slow") or RANDOM.intersection(item.path.parts):
            item.add_marker("no_cover")


@pytest.fixture
def update_golden(request: pytest.FixtureRequest) -> bool:
    """Whether golden files are to be written."""
    return bool(request.config.getoption("--update-golden"))
