"""Options of the whole test suite."""

from __future__ import annotations

import gc
import os
import re
import shutil
import signal
from collections import defaultdict
from collections.abc import Iterable
from functools import cache
from itertools import count
from pathlib import Path
from types import ModuleType

import pytest
import seeds
from hypothesis import settings
from hypothesis.internal.conjecture import providers
from interpreters import TRIED_ONCE

# How long an example takes is the machine's matter.
settings.register_profile("rtgen", deadline=None)
settings.load_profile("rtgen")

# Otherwise what a seed draws would depend on the modules that other tests have loaded, all of
# which each process would parse for their constants.
providers._get_local_constants = providers.Constants

# The default bus of python-can: no test may access a real one.
for _variable in ("CAN_INTERFACE", "CAN_CHANNEL", "CAN_BITRATE", "CAN_CONFIG"):
    os.environ.pop(_variable, None)

# Messages are English, whatever the locale of who runs the tests.
os.environ["LC_ALL"] = "C.UTF-8"

# In the background Ctrl-C is ignored, also by the processes that tests start and interrupt.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)
# With nohup SIGHUP is: this process goes on, but those that tests start get it.
if hasattr(signal, "SIGHUP") and signal.getsignal(signal.SIGHUP) is signal.SIG_IGN:
    signal.signal(signal.SIGHUP, lambda *_: None)

# What is collected lives to the end: the garbage collector need not look at it again and again.
gc.disable()

TESTS = Path(__file__).parent
_FOLDERS = count()
DRAWN = {seeds.seed, seeds.budget, seeds.cases}
"""A file that uses one of them has tests with many drawn inputs."""


MEMORY = Path("/dev/shm")
"""A file system in memory, where there is one (Linux): tests create some 40,000 files."""
MIN_FREE = 4 << 30
"""Octets that must be free there."""


@pytest.hookimpl(tryfirst=True)
def pytest_configure(config: pytest.Config) -> None:
    """Hypothesis draws by the seed of the run, unless it is given one of its own."""
    if config.option.hypothesis_seed is None:
        config.option.hypothesis_seed = str(seeds.seed())
    if os.access(MEMORY, os.W_OK) and shutil.disk_usage(MEMORY).free > MIN_FREE:
        os.environ.setdefault("PYTEST_DEBUG_TEMPROOT", str(MEMORY))


def pytest_report_header() -> str:
    """How a run is repeated."""
    return f"random tests: RTGEN_SEED={seeds.seed()}"


def pytest_addoption(parser: pytest.Parser) -> None:
    """One flag renews every golden file; the diff is then for a reviewer."""
    parser.addoption(
        "--update-golden",
        action="store_true",
        help="Write golden files instead of comparing.",
    )


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Repetition covers nothing more: what is random or slow runs without being traced.

    `make fuzz` selects what is random by its marker.

    OpenRTM's manager is the process's until its end, with an ORB and loggers that keep their
    settings, so its tests come last; of them those first that would hold up the end of a run.
    """
    items.sort(key=_turn)
    _leave_to_nightly(items)
    for item in items:
        assert isinstance(item, pytest.Function)
        is_random = _draws(item.module)
        if is_random:
            item.add_marker("random")
        if is_random or item.get_closest_marker("slow"):
            item.add_marker("no_cover")
        in_turns = item.get_closest_marker("in_turns") is not None
        if not (seeds.has_turn(item.name) if in_turns else _has_turn(item.path)):
            item.add_marker("postponed")


@cache
def _draws(module: ModuleType) -> bool:
    return any(getattr(module, f.__name__, None) is f for f in DRAWN)


@cache
def _has_turn(file: Path) -> bool:
    return seeds.has_turn(file.relative_to(TESTS).as_posix())


def _leave_to_nightly(items: Iterable[pytest.Item]) -> None:
    """Mark the cases of sampled tests with `nightly`, except as many as the marker states.

    Those are the same each time, evenly distributed over all cases.
    """
    cases: dict[str, list[pytest.Item]] = defaultdict(list)
    for item in items:
        if item.get_closest_marker("sampled") and not item.get_closest_marker(
            "nightly"
        ):
            cases[item.nodeid.partition("[")[0]].append(item)
    for group in cases.values():
        marker = group[0].get_closest_marker("sampled")
        assert marker is not None
        size, [taken] = len(group), marker.args
        kept = {size * turn // taken for turn in range(taken)}
        for index, item in enumerate(group):
            if index not in kept:
                item.add_marker("nightly")
                if _is_tried_on_each(item):
                    item.add_marker("left_out")


def _is_tried_on_each(item: pytest.Item) -> bool:
    """Return whether the further interpreter of `make nightly` runs a case (`interpreters`)."""
    is_slow = any(map(item.get_closest_marker, ("slow", "peer")))
    return not is_slow and not _is_tried_once(item.path)


@cache
def _is_tried_once(file: Path) -> bool:
    return any(file.is_relative_to(TESTS.parent / each) for each in TRIED_ONCE)


def _turn(item: pytest.Item) -> tuple[bool, bool]:
    """What is run later is greater."""
    last = item.path.parent == TESTS / "openrtm"
    return last, last and item.get_closest_marker("longest") is None


@pytest.hookimpl(optionalhook=True)
def pytest_handlecrashitem(crashitem: str) -> None:
    """End the run if one of its processes has crashed, which no repetition excuses."""
    pytest.exit(f"a process crashed during {crashitem}", pytest.ExitCode.INTERNAL_ERROR)


def pytest_collection_finish() -> None:
    """Leave what has been collected out of garbage collections, which are made less often."""
    gc.freeze()
    gc.enable()
    gc.set_threshold(50_000, 20, 100)


@pytest.fixture
def tmp_path(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> Path:
    """pytest's own looks through the folders of all tests before it makes one."""
    folder = tmp_path_factory.getbasetemp() / str(next(_FOLDERS))
    name = re.sub(r"\W", "_", request.node.name)[:30]
    made = folder / f"{name}0"
    made.mkdir(parents=True)
    return made


@pytest.fixture
def update_golden(request: pytest.FixtureRequest) -> bool:
    """Whether golden files are to be written."""
    return bool(request.config.getoption("--update-golden"))
