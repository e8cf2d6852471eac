"""The start of modules for OpenRTM, as far as it needs no OpenRTM."""

from __future__ import annotations

import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

from rtgen.runtime.openrtm.contexts import PollingGuard
from rtgen.runtime.openrtm.starting import arguments, instance_arguments


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
