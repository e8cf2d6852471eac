"""What tests of the target openrtm share in a process.

The reference build generated for it; OpenRTM's stubs, a naming service, and a manager.
"""

from __future__ import annotations

import importlib
import os
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import hosting
import middleware
import pytest
from openrtm_lab import Lab

from rtgen.cli import run
from rtgen.runtime.corba.name_server import NameServer
from rtgen.runtime.failures import log

ROOT = Path(__file__).resolve().parents[2]


ORB_OPTIONS = "-ORBnativeCharCodeSet UTF-8 -ORBgiopMaxMsgSize 67108864"
"""Those of the runtime: a worker may take tests of other folders after OpenRTM's."""


@pytest.fixture(scope="module", autouse=True)
def runtime_log() -> Iterator[None]:
    """What a module hangs on the runtime's log goes with it: other tests count messages."""
    before = list(log.handlers)
    yield
    for handler in [each for each in log.handlers if each not in before]:
        log.removeHandler(handler)


@pytest.fixture(scope="session")
def reference(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The output folder of the reference build: `<out>/openrtm/<Component>/`, and its packages."""
    folder = tmp_path_factory.mktemp("reference")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(ROOT)
        arguments = ["generate", "--target", "openrtm", "-o", str(folder), "-q"]
        code = run(arguments)
    assert code == 0
    return folder / "generated"


@pytest.fixture(scope="session")
def rtm_folders(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """Folders that make `OpenRTM_aist`, `RTC` and the other stubs importable; none if installed."""
    if middleware.REAL:
        return []
    stubs = middleware.compile_stubs(tmp_path_factory.mktemp("rtm"))
    return middleware.search_path(stubs)


@pytest.fixture(scope="session")
def rtm_environment(rtm_folders: list[Path]) -> dict[str, str]:
    """The environment of processes that import `OpenRTM_aist`."""
    return middleware.environment(rtm_folders)


@pytest.fixture(scope="session")
def naming_service() -> Iterator[str]:
    """`host:port` of a naming service."""
    with NameServer() as service:
        yield service.address


@pytest.fixture(scope="session")
def manager(
    rtm_folders: list[Path],
    naming_service: str,
    tmp_path_factory: pytest.TempPathFactory,
) -> Iterator[Any]:
    """A manager in this process; components of it are driven by ticks."""
    sys.path.extend(map(str, rtm_folders))
    rtm = importlib.import_module("OpenRTM_aist")
    options = {
        "corba.nameservers": naming_service,
        "corba.endpoints": "127.0.0.1:",
        "corba.args": f"-ORBclientCallTimeOutPeriod 10000 {ORB_OPTIONS}",
        "exec_cxt.periodic.type": "ExtTrigExecutionContext",
        "logger.enable": "NO",
        "manager.shutdown_on_nortcs": "NO",
        "naming.formats": "%n.rtc",
    }
    settings = [
        text for key, value in options.items() for text in ("-o", f"{key}:{value}")
    ]
    # The folder of tests may have an rtc.conf of somebody else's.
    before = Path.cwd()
    os.chdir(tmp_path_factory.mktemp("manager"))
    try:
        running = rtm.Manager.init(["tests", *settings])
    finally:
        os.chdir(before)
    running.activateManager()
    running.runManager(True)
    yield running
    # `ORB.destroy` ends the process if a thread is still in a call. The ORB is the process's.
    running.shutdownORB = lambda: running.getORB().shutdown(True)
    running.shutdown()


def _unless(skipped: bool, reason: str) -> list[pytest.MarkDecorator]:
    return [pytest.mark.skip(reason=reason)] if skipped else []


@pytest.fixture(
    params=[
        pytest.param(
            "stub", marks=_unless(middleware.REAL, "OpenRTM-aist-Python is installed")
        ),
        pytest.param(
            "real",
            marks=_unless(not middleware.REAL, "OpenRTM-aist-Python is not installed"),
        ),
    ]
)
def openrtm(request: pytest.FixtureRequest) -> str:
    """Which OpenRTM a test runs on: the real one wherever there is one, else the stub."""
    return str(request.param)


@pytest.fixture
def rtm(openrtm: str, manager: Any) -> Any:
    """The package `OpenRTM_aist`, with a manager that runs."""
    return importlib.import_module("OpenRTM_aist")


@pytest.fixture
def lab(rtm: Any, manager: Any) -> Iterator[Lab]:
    """Components of one test."""
    made = Lab(rtm, manager)
    yield made
    made.close()


@pytest.fixture(scope="session")
def facts(manager: Any, tmp_path_factory: pytest.TempPathFactory) -> Any:
    """The module `Facts`: types and services of `facts.idl`."""
    folder = tmp_path_factory.mktemp("facts")
    middleware.compile_idl(folder, [Path(__file__).with_name("facts.idl")])
    sys.path.append(str(folder))
    return importlib.import_module("Facts")


@pytest.fixture(scope="session")
def orb(rtm_folders: list[Path]) -> Any:
    """omniORB in this process, as a manager starts it; it lives as long as the process."""
    sys.path.extend(str(path) for path in rtm_folders if str(path) not in sys.path)
    corba = importlib.import_module("omniORB.CORBA")
    options = [*ORB_OPTIONS.split(), "-ORBendPoint", "giop:tcp:127.0.0.1:0"]
    running = corba.ORB_init(["tests", *options])
    poa = running.resolve_initial_references("RootPOA")
    poa._get_the_POAManager().activate()
    return running


@pytest.fixture(scope="session")
def relay_module(
    manager: Any, rtm_folders: list[Path], tmp_path_factory: pytest.TempPathFactory
) -> Any:
    """The generated module `Relay.py`, known to the manager."""
    component = hosting.generate(tmp_path_factory.mktemp("hosted"))
    hosting.compile_stubs(component, rtm_folders)
    loaded = hosting.load(component)
    loaded.RelayInit(manager)
    return loaded


@pytest.fixture
def relay(relay_module: Any, lab: Lab) -> hosting.Relay:
    """A relay, initialized; of what others were given nothing is left to it."""
    name = lab.unused("Relay")
    made = lab.create(f"Relay?instance_name={name}&conf.default.gain=2.0")
    return hosting.Relay(made, lab)
