"""The start of modules for OpenRTM, as far as it needs no OpenRTM."""

from __future__ import annotations

import _thread
import subprocess
import sys
import threading
import time
from pathlib import Path
from types import ModuleType, SimpleNamespace

import pytest

from rtgen.runtime.failures import log
from rtgen.runtime.openrtm.contexts import PollingGuard
from rtgen.runtime.openrtm.starting import arguments, instance_arguments, main


@pytest.fixture(autouse=True)
def nowhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("RTC_MANAGER_CONFIG", raising=False)


def test_a_managers_own_arguments_are_left(tmp_path: Path) -> None:
    given = ["Relay.py", "-f", "my.conf", "--instance_name=Left0", "-o", "a:b"]
    kept = ["Relay.py", "-f", "my.conf", "-o", "a:b"]
    assert arguments(given, tmp_path, "Tests", "Relay") == kept


def test_the_configuration_beside_the_module_is_the_last_resort(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "Relay"
    own = [
        "Relay.py",
        *("-f", str(folder / "rtc.conf")),
        *("-o", f"Tests.Relay.config_file:{folder / 'Relay.conf'}"),
        "-d",
    ]
    assert arguments(["Relay.py", "-d"], folder, "Tests", "Relay") == own
    Path("rtc.conf").write_text("")
    assert arguments(["Relay.py"], folder, "Tests", "Relay") == ["Relay.py"]
    Path("rtc.conf").unlink()
    monkeypatch.setenv("RTC_MANAGER_CONFIG", "/etc/mine.conf")
    assert arguments(["Relay.py"], folder, "Tests", "Relay") == ["Relay.py"]


def test_an_instance_has_the_name_that_is_given() -> None:
    assert instance_arguments(["Relay.py"]) == ""
    given = ["Relay.py", "-d", "--instance_name=Left0"]
    assert instance_arguments(given) == "?instance_name=Left0"


def test_a_module_ends_after_the_threads_of_its_orb(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    omniorb = pytest.importorskip("omniORB")
    begun, leaving, ended = threading.Event(), threading.Event(), threading.Event()

    def worker() -> None:
        registered = omniorb.WorkerThread()
        begun.set()
        leaving.wait(20)
        ended.set()
        registered.delete()

    def run() -> None:
        # Like omniORB's own threads, this one is unknown to `threading`.
        _thread.start_new_thread(worker, ())
        assert begun.wait(20)
        threading.Timer(0.1, leaving.set).start()

    manager = SimpleNamespace(
        setModuleInitProc=lambda init: None,
        activateManager=lambda: None,
        runManager=run,
    )
    module = ModuleType("OpenRTM_aist")
    module.Manager = SimpleNamespace(init=lambda words: manager)  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "OpenRTM_aist", module)
    monkeypatch.setattr(log, "handlers", list(log.handlers))
    main(lambda manager: None, tmp_path, "Tests", "Relay")
    assert ended.is_set()


def test_a_guard_looks_by_itself() -> None:
    guard = PollingGuard()
    found: list[int] = []
    timer = threading.Timer(0.02, found.append, [1])
    timer.start()
    with guard:
        assert guard.wait_for(lambda: bool(found), 5.0)
        begun = time.monotonic()
        assert not guard.wait_for(lambda: False, 0.01)
        assert time.monotonic() >= begun + 0.01
    timer.join()


def test_nothing_of_openrtm_is_imported_before_it_is_used() -> None:
    code = (
        "import sys, rtgen.runtime.openrtm, rtgen.runtime.openrtm.host\n"
        "print([m for m in sys.modules if m.startswith(('OpenRTM', 'omniORB', 'RTC'))])"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    )
    assert done.stdout == "[]\n"
