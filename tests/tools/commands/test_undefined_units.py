"""Units of components without a definition are those that their profiles state."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from small_systems import data_port, system_text

from rtgen.cli import run as rtgen

MODULE = """
from rtgen.runtime import Component, ComponentProfile, PortProfile
from rtgen.runtime.library.rtc import TimedPose2D


def port(kind, name, unit):
    return PortProfile(name, name, kind, "RTC::TimedPose2D", "", unit=unit)


class Source(Component):
    profile = ComponentProfile("Source", ports=(port("outport", "given", "m, deg"),))

    def __init__(self, instance_name=None):
        super().__init__(instance_name)
        self.given = self.add_out_port("given", TimedPose2D)


class Sink(Component):
    profile = ComponentProfile(
        "Sink",
        ports=tuple(
            port("inport", name, unit)
            for name, unit in (
                ("same", "m, deg"), ("scale", "m, rad"), ("other", "s, deg"), ("none", "")
            )
        ),
    )

    def __init__(self, instance_name=None):
        super().__init__(instance_name)
        for name in ("same", "scale", "other", "none"):
            self.add_in_port(name, TimedPose2D)
"""
ALLOWED = """
    <rtsExt:Properties rtsExt:name="rtgen.allow.RTC0593" rtsExt:value="measured so"/>
  </rts:DataPortConnectors>"""
END = "\n  </rts:DataPortConnectors>"


@pytest.fixture(autouse=True)
def _project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", list(sys.path))
    (tmp_path / "src").mkdir()
    (tmp_path / "src" / "undefined.py").write_text(MODULE)
    (tmp_path / "rtgen.toml").write_text(
        '[components]\nSource = "undefined:Source"\nSink = "undefined:Sink"\n'
    )
    yield
    sys.modules.pop("undefined", None)


@pytest.mark.parametrize(
    ("port", "allowed", "verdict"),
    [
        ("same", False, ""),
        ("none", False, ""),
        ("scale", False, "warning[RTC0595]"),
        ("other", False, "error[RTC0593]"),
        ("other", True, ""),
    ],
)
def test_a_run_compares_what_profiles_state(
    port: str, allowed: bool, verdict: str, capfd: pytest.CaptureFixture[str]
) -> None:
    wire = data_port("A0.given", f"B0.{port}", "IDL:RTC/TimedPose2D:1.0")
    if allowed:
        wire = wire.replace(END, ALLOWED)
    Path("s.xml").write_text(system_text({"A0": "Source", "B0": "Sink"}, wire))
    code = rtgen(["run", "s.xml", "--until", "0.1", "-q"])
    said = capfd.readouterr().err
    assert code == (2 if "error" in verdict else 0), said
    assert verdict in said if verdict else said == ""
    if port == "scale":
        assert 'units = { "data.heading" = ["deg", "rad"] }' in said
