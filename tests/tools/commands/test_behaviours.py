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


CALLBACKS = [
    *("on_initialize", "on_finalize", "on_startup", "on_shutdown", "on_activated"),
    *("on_deactivated", "on_aborting", "on_error", "on_reset", "on_execute"),
    *("on_state_update", "on_rate_changed"),
]


def _methods(*names: str) -> None:
    """Add methods to the behaviour, in front of its own."""
    text = Path(CONTROLLER).read_text()
    head, mark, rest = text.partition("    def on_execute")
    made = "".join(f"    def {name}(self, ec_id: int) -> None: ...\n" for name in names)
    Path(CONTROLLER).write_text(head + made + mark + rest)


MISSPELT = {
    "on_excute": "on_execute",
    "on_activate": "on_activated",
    "on_deactivate": "on_deactivated",
    "on_intialize": "on_initialize",
    "on_initialise": "on_initialize",
    "on_start_up": "on_startup",
    "on_stateupdate": "on_state_update",
    "on_ratechanged": "on_rate_changed",
    "onExecute": "on_execute",
    "onRateChanged": "on_rate_changed",
    "On_Execute": "on_execute",
    **{name[:6] + name[7:]: name for name in CALLBACKS},
}
OTHERS = ("on_exec", "on_goal", "on_write", "only_once", "execute")


@pytest.mark.parametrize("command", ["check", "lint"])
def test_misspelt_callbacks(command: str, capfd: pytest.CaptureFixture[str]) -> None:
    _methods(*MISSPELT, *OTHERS)
    lines = Path(CONTROLLER).read_text().split("\n")
    assert run([command, "--diagnostics", "json"]) == 1
    hints = {}
    for finding in _findings(capfd):
        if finding["code"] == "PRJ0014":
            rest = lines[int(finding["line"]) - 1][int(finding["column"]) - 1 :]  # type: ignore[call-overload]
            hints[rest.partition("(")[0]] = finding["hint"]
    assert hints == {name: f"did you mean {meant}?" for name, meant in MISSPELT.items()}


def test_each_callback_is_known(capfd: pytest.CaptureFixture[str]) -> None:
    _methods(*(name for name in CALLBACKS if name != "on_execute"), *OTHERS)
    assert run(["check"]) == 0
    run(["lint"])
    assert "PRJ0014" not in capfd.readouterr().err


def test_methods_that_are_called_or_of_other_classes_are_no_callbacks(
    capfd: pytest.CaptureFixture[str],
) -> None:
    text = Path(CONTROLLER).read_text()
    Path(CONTROLLER).write_text(
        text
        + "        self.on_excute()\n        return RTC_OK\n\n"
        + "    def on_excute(self) -> None: ...\n\n\n"
        + "class Helper:\n    def on_activate(self) -> None: ...\n"
    )
    assert run(["check"]) == 0
    run(["lint"])
    assert "PRJ0014" not in capfd.readouterr().err


def test_a_callback_can_be_ignored(capfd: pytest.CaptureFixture[str]) -> None:
    _methods("on_excute")
    run(["lint"])
    assert "PRJ0014" in capfd.readouterr().err
    run(["lint", "--ignore", "PRJ0014"])
    assert "PRJ0014" not in capfd.readouterr().err
    Path(CONTROLLER).write_text(Path(CONTROLLER).read_text() + "    def broken(:\n")
    run(["lint"])
    err = capfd.readouterr().err
    assert "Traceback" not in err
    assert "PRJ0014" not in err
