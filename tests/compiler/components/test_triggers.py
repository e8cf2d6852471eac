"""Components that are executed by samples at named ports: IDL, profiles, generated classes."""

from __future__ import annotations

from pathlib import Path

import pytest

from rtgen.cli import run

IDL = """\
#include "BasicDataType.idl"

@rtc(category="Test", vendor="Lab", activity="EVENTDRIVEN", triggers="{triggers}")
component Fusion {{
    consumes RTC::TimedLong scan;
    consumes RTC::TimedLong goal;
    consumes RTC::TimedLong aside;
    publishes RTC::TimedLong pose;
}};
"""
SETTINGS = """\
[sources]
paths = ["Fusion.idl"]
[output]
package = "fused"
"""
SPECS = Path(__file__).resolve().parents[3] / "specs/idl"


@pytest.mark.parametrize(
    ("triggers", "literal"),
    [("scan, goal", '("scan", "goal")'), (" scan", '("scan",)'), ("", "")],
)
def test_there_and_back(
    triggers: str,
    literal: str,
    tmp_path: Path,
    capfd: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    file = tmp_path / "Fusion.idl"
    file.write_text(IDL.format(triggers=triggers), encoding="utf-8")
    (tmp_path / "rtgen.toml").write_text(SETTINGS, encoding="utf-8")
    assert run(["generate", "-q"]) == 0, capfd.readouterr()
    folder = tmp_path / "generated/fused/components/fusion"
    text = "".join((folder / "__init__.py").read_text("utf-8").split())
    assert 'activity="EVENTDRIVEN"' in text
    assert ("triggers=" in text) == bool(literal)
    assert f"triggers={literal}".replace(" ", "") in text or not literal
    assert run(["generate", "--target", "small", "-q"]) == 0
    (small,) = (tmp_path / "generated/small").glob("**/components/fusion.py")
    assert f"_triggers = {literal or '()'}" in small.read_text("utf-8")
    words = ["convert", str(folder / "RTC.xml"), "--to", "idl", "-I", str(SPECS), "-q"]
    assert run(words) == 0
    again = capfd.readouterr().out
    assert f'triggers="{triggers}"' in again


def test_a_port_that_is_not_there_is_an_error(
    tmp_path: Path,
    capfd: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    file = tmp_path / "Fusion.idl"
    file.write_text(IDL.format(triggers="scan, goall, pose"), encoding="utf-8")
    (tmp_path / "rtgen.toml").write_text(SETTINGS, encoding="utf-8")
    assert run(["generate", "-q"]) == 2
    message = capfd.readouterr().err
    assert message.count("RTC0105") == 2
    assert "did you mean goal? InPorts: scan, goal, aside" in message


@pytest.mark.parametrize("activity", ["PERIODIC", "SPORADIC"])
def test_triggers_of_another_activity_are_an_error(
    activity: str,
    tmp_path: Path,
    capfd: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    text = IDL.format(triggers="scan").replace("EVENTDRIVEN", activity)
    (tmp_path / "Fusion.idl").write_text(text, encoding="utf-8")
    assert run(["generate", "Fusion.idl", "-q"]) == 2
    message = capfd.readouterr().err
    assert f"RTC0105]: `triggers` has no effect: the activity is {activity}" in message
    assert 'hint: write activity="EVENTDRIVEN"' in message
