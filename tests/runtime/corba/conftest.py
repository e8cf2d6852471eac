"""Fixtures of runs over omniORB: a project, a naming service, processes.

Modules of omniORB are imported on their first use: the tests are skipped without it.
"""

from __future__ import annotations

import importlib
import shutil
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from rtgen.cli import run as rtgen

if TYPE_CHECKING:
    from corba_runs import Here, Run
    from gauge_component import Bench


@pytest.fixture(scope="session")
def generated_project(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a project with a component that calls and one that is called."""
    folder = tmp_path_factory.mktemp("corba") / "project"
    shutil.copytree(Path(__file__).with_name("corba_system"), folder)
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        assert rtgen(["generate", "-q"]) == 0
    return folder


@pytest.fixture(scope="module")
def project(generated_project: Path) -> Iterator[Path]:
    """Make the project the working folder of a module's tests."""
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(generated_project)
        added = [str(generated_project), str(generated_project / "generated")]
        patch.setattr(sys, "path", [*added, *sys.path])
        importlib.invalidate_caches()
        yield generated_project


@pytest.fixture(scope="module")
def names() -> Iterator[str]:
    """Yield the address of a naming service."""
    from rtgen.runtime.corba.name_server import NameServer

    with NameServer() as server:
        yield server.address


@pytest.fixture
def start(project: Path, names: str) -> Iterator[Callable[..., Run]]:
    """Yield a function that starts processes, which end with the test."""
    from corba_runs import Run

    runs: list[Run] = []

    def started(*arguments: str, **more: Path) -> Run:
        runs.append(Run(project, "--nameserver", names, *arguments, **more))
        return runs[-1]

    yield started
    for run in runs:
        run.kill()


@pytest.fixture
def serving(start: Callable[..., Run]) -> Callable[[], Run]:
    """Return a function that starts a process with Counter0, and waits until it is ACTIVE."""

    def started() -> Run:
        run = start("--only", "Counter0")
        run.wait_for("Counter0 ACTIVE")
        return run

    return started


@pytest.fixture
def stack() -> Iterator[ExitStack]:
    with ExitStack() as stack:
        yield stack


@pytest.fixture
def here(project: Path, names: str, stack: ExitStack) -> Here:
    from corba_runs import Here

    return Here(stack, names)


@pytest.fixture(scope="module")
def gauge_project(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """Make a project with the component Gauge the working folder of a module's tests."""
    from gauge_component import IDL, SETTINGS

    folder = tmp_path_factory.mktemp("gauge")
    (folder / "gauge.idl").write_text(IDL)
    (folder / "rtgen.toml").write_text(SETTINGS)
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        assert rtgen(["generate", "-q"]) == 0
        patch.setattr(sys, "path", [str(folder / "generated"), *sys.path])
        importlib.invalidate_caches()
        yield folder


@pytest.fixture(scope="module")
def bench(gauge_project: Path, names: str) -> Iterator[Bench]:
    """Yield the running component Gauge."""
    from gauge_component import running

    with running(gauge_project, names) as bench:
        yield bench
