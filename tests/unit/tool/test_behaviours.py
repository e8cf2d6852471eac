"""Renamed components and ports: the old behaviour file and old uses are reported."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from user_project import CONTROLLER, write

from rtgen.cli import run

IDL = Path("idl/heating.idl")


@pytest.fixture(autouse=True)
def _project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write(tmp_path)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("RTGEN_CACHE_DIR", str(tmp_path / "cache"))


def _rename(old: str, new: str) -> None:
    text = IDL.read_text()
    assert old in text
    IDL.write_text(text.replace(old, new))


def _findings(capfd: pytest.CaptureFixture[str]) -> list[dict[str, object]]:
    found: list[dict[str, object]] = json.loads(capfd.readouterr().err)
    return found


def test_nothing_is_reported_of_a_project_that_fits(
    capfd: pytest.CaptureFixture[str],
) -> None:
    assert run(["check"]) == 0
    assert capfd.readouterr() == ("", "")


def test_a_renamed_component_leaves_a_skeleton(
    capfd: pytest.CaptureFixture[str],
) -> None:
    _rename("component Controller", "component Controllers")
    assert run(["generate", "--diagnostics", "json"]) == 0
    [finding] = _findings(capfd)
    assert (finding["code"], finding["severity"]) == ("PRJ0012", "warning")
    assert (finding["file"], finding["line"], finding["column"]) == (CONTROLLER, 6, 24)
    assert finding["hint"] == "was it renamed to controllers?"
    assert run(["check", "--diagnostics", "json"]) == 1
    assert _findings(capfd) == [finding]
    Path(CONTROLLER).unlink()
    assert run(["check"]) == 0


def test_a_renamed_port_is_still_used(capfd: pytest.CaptureFixture[str]) -> None:
    _rename("publishes Heating::Power power", "publishes Heating::Power powers")
    assert run(["generate", "-q"]) == 0
    err = capfd.readouterr().err
    assert (
        f"{CONTROLLER}:18:18: warning[PRJ0013]: the definition has no port 'power'"
        in err
    )
    assert "hint: did you mean powers?" in err
    assert run(["check"]) == 1


@pytest.mark.parametrize(
    "made",
    [
        "        self.power = self.log = Log()\n",
        "        self.power: Log = Log()\n",
        "        self.power, self.other = Log(), 3\n",
    ],
)
def test_what_a_behaviour_makes_itself_is_no_port(
    made: str, capfd: pytest.CaptureFixture[str]
) -> None:
    _rename("publishes Heating::Power power", "publishes Heating::Power powers")
    file = Path(CONTROLLER)
    text = file.read_text()
    first = '        """Full power below the target, none above."""\n'
    file.write_text(text.replace(first, first + made))
    assert run(["generate", "-q"]) == 0
    assert capfd.readouterr().err == ""
