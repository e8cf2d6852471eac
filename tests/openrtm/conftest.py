"""Fixtures of the target openrtm that tests of a process share.

The generated reference build; OpenRTM's stubs, a naming service, and a manager.
"""

from __future__ import annotations

import importlib
import os
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import cpp_build
import devices
import hosting
import middleware
import pytest
from openrtm_lab import Lab

from rtgen.cli import run
from rtgen.runtime.corba.name_server import NameServer
from rtgen.runtime.failures import log

ROOT = Path(__file__).resolve().parents[2]


ORB_OPTIONS = "-ORBnativeCharCodeSet UTF-8 -ORBgiopMaxMsgSize 67108864"
"""The options of the runtime: a worker may run tests of other folders after OpenRTM's."""


@pytest.fixture(scope="module", autouse=True)
def runtime_log() -> Iterator[None]:
    """Remove the handlers that a module adds to the runtime's log: other tests count messages."""
    before = list(log.handlers)
    yield
    for handler in [each for each in log.handlers if each not in before]:
        log.removeHandler(handler)


@pytest.fixture(scope="session")
def reference(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the output folder of the reference build: `<out>/openrtm/<Component>/` and more."""
    folder = tmp_path_factory.mktemp("reference")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(ROOT)
        arguments = ["generate", "--target", "openrtm", "-o", str(folder), "-q"]
        code = run(arguments)
    assert code == 0
    return folder / "generated"


@pytest.fixture(scope="session")
def rtm_folders(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """Return folders that make `OpenRTM_aist`, `RTC` and the other stubs importable.

    None if OpenRTM is installed.
    """
    if middleware.REAL:
        return []
    stubs = middleware.compile_stubs(tmp_path_factory.mktemp("rtm"))
    return middleware.search_path(stubs)


@pytest.fixture(scope="session")
def rtm_environment(rtm_folders: list[Path]) -> dict[str, str]:
    """Return the environment of processes that import `OpenRTM_aist`."""
    return middleware.environment(rtm_folders)


@pytest.fixture(scope="session")
def cpp_programs() -> Path:
    """Return the folder with the programs of `cpp`, compiled."""
    data = ("BasicDataType", "ExtendedDataTypes", "intellirobot")
    idl = [middleware.DATA_TYPES / f"{name}.idl" for name in data]
    interfaces = ("SDOPackage", "RTC", "OpenRTM")
    idl += [middleware.STUB / "idl" / f"{name}.idl" for name in interfaces]
    source = Path(__file__).parent / "cpp"
    return cpp_build.programs(idl, source)


@pytest.fixture(scope="session")
def piloted(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the generated project of `devices`."""
    return devices.project(tmp_path_factory.mktemp("piloted"))


@pytest.fixture
def processes(
    piloted: Path, tmp_path: Path, cpp_programs: Path, naming_service: str
) -> Iterator[devices.Processes]:
    """Yield the processes of a test with devices in C++."""
    with devices.processes(piloted, tmp_path, cpp_programs, naming_service) as made:
        yield made


@pytest.fixture(scope="session")
def naming_service() -> Iterator[str]:
    """Yield `host:port` of a naming service."""
    with NameServer() as service:
        yield service.address


@pytest.fixture(scope="session")
def manager(
    rtm_folders: list[Path],
    naming_service: str,
    tmp_path_factory: pytest.TempPathFactory,
) -> Iterator[Any]:
    """Yield a manager in this process; its components are driven by ticks."""
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
    # The folder of tests may have an rtc.conf.
    before = Path.cwd()
    os.chdir(tmp_path_factory.mktemp("manager"))
    try:
        running = rtm.Manager.init(["tests", *settings])
    finally:
        os.chdir(before)
    running.activateManager()
    running.runManager(True)
    yield running
    # `ORB.destroy` ends the process if a thread is still in a call. The ORB is global.
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
    """Return which OpenRTM a test uses: the real one if there is one, else the stub."""
    return str(request.param)


@pytest.fixture
def rtm(openrtm: str, manager: Any) -> Any:
    """Return the package `OpenRTM_aist`, with a running manager."""
    return importlib.import_module("OpenRTM_aist")


@pytest.fixture
def lab(rtm: Any, manager: Any) -> Iterator[Lab]:
    """Yield the components of one test."""
    made = Lab(rtm, manager)
    yield made
    made.close()


@pytest.fixture(scope="session")
def facts(manager: Any, tmp_path_factory: pytest.TempPathFactory) -> Any:
    """Import the module `Facts`: types and services of `facts.idl`."""
    folder = tmp_path_factory.mktemp("facts")
    middleware.compile_idl(folder, [Path(__file__).with_name("facts.idl")])
    sys.path.append(str(folder))
    return importlib.import_module("Facts")


@pytest.fixture(scope="session")
def orb(rtm_folders: list[Path]) -> Any:
    """Return omniORB in this process, started as by a manager, until the process ends."""
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
    """Load the generated module `Relay.py` in the manager."""
    component = hosting.generate(tmp_path_factory.mktemp("hosted"))
    hosting.compile_stubs(component, rtm_folders)
    loaded = hosting.load(component)
    loaded.RelayInit(manager)
    return loaded


@pytest.fixture
def relay(relay_module: Any, lab: Lab) -> hosting.Relay:
    """Return an initialized relay without state of earlier tests."""
    name = lab.unused("Relay")
    made = lab.create(f"Relay?instance_name={name}&conf.default.gain=2.0")
    return hosting.Relay(made, lab)
