"""`rtgen run` on small components without ports: start, end, values, report, refusals."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from patience import PATIENCE

from rtgen.cli import run as rtgen

pytestmark = pytest.mark.waits

MODULE = '''
import math
import sys
from dataclasses import dataclass

from rtgen.runtime import RTC_OK, Component, ComponentProfile, ParameterProfile


@dataclass(slots=True)
class Configuration:
    speed: float = 1.0
    distance: float = 2.0


class Mover(Component):
    """Drives along x; ends in ERROR once it is there."""

    profile = ComponentProfile(
        "Mover",
        rate=100.0,
        configuration=(
            ParameterProfile("speed", "speed", "double", "1.0", minimum=0.0),
            ParameterProfile("distance", "distance", "double", "2.0"),
        ),
    )

    def __init__(self, instance_name=None):
        super().__init__(instance_name)
        self.config = self.add_configuration(Configuration())
        self.x = 0.0
        self.observables["pose"] = lambda: (self.x, 0.0, math.tau)
        self.observables["speed"] = lambda: self.config.speed
        self.observables["broken"] = lambda: 1 / 0
        self.observables["goal"] = lambda: (self.config.distance, 0.0, 0.0)
        self.observables["turned"] = lambda: (self.config.distance, 0.0, 0.5)
        self.observables["nowhere"] = lambda: ()

    def on_execute(self, ec_id):
        self.x += self.config.speed * 0.01
        if self.x >= self.config.distance - 1e-9:
            return self.fail("arrived")
        return RTC_OK


class Ending(Mover):
    """Says when it is finalized."""

    def on_finalize(self):
        sys.stderr.write("finalized.")
        return RTC_OK


class Printing(Ending):
    def on_execute(self, ec_id):
        print("x" * 9999, flush=True)
        return RTC_OK


class Broken(Component):
    profile = ComponentProfile("Broken")

    def on_initialize(self):
        return self.fail("no motor")


class Waiting(Component):
    """Its activation waits for a second."""

    profile = ComponentProfile("Waiting", rate=100.0)

    def _gate(self, request):
        self._awaited = "a second to pass"
        return RTC_OK if self.now() >= 1_000_000_000 else None


class Hindered(Component):
    """Reports a missing condition for the first second, or for ever."""

    profile = ComponentProfile("Hindered", rate=100.0)

    def on_execute(self, ec_id):
        over = self.instance_name == "H1" and self.now() >= 1_000_000_000
        self.report("" if over else "no scan for 0.5 s")
        return RTC_OK


def no_component(name):
    return 3


def raising(name):
    raise ValueError("bad luck")
'''

COMPONENT = """
  <rts:Components xsi:type="rtsExt:component_ext" rts:id="RTC:v:c:{type}:1.0.0"
      rts:instanceName="{name}" rts:pathUri="localhost/{name}.rtc" rts:compositeType="None"
      rts:isRequired="true" rts:activeConfigurationSet="default">{sets}
  </rts:Components>"""


def profile(*components: tuple[str, str], sets: str = "", **properties: str) -> str:
    boxes = "".join(COMPONENT.format(type=t, name=n, sets=sets) for t, n in components)
    known = "".join(
        f'\n  <rtsExt:Properties rtsExt:name="rtgen.run.{k}" rtsExt:value="{v}"/>'
        for k, v in properties.items()
    )
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        '<rts:RtsProfile rts:id="RTSystem:v:test:1.0.0" rts:version="0.2" rts:abstract="a"\n'
        '    rts:creationDate="1970-01-01T00:00:00" rts:updateDate="1970-01-01T00:00:00"\n'
        '    xmlns:rts="http://www.openrtp.org/namespaces/rts"\n'
        '    xmlns:rtsExt="http://www.openrtp.org/namespaces/rts_ext"\n'
        '    xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance">'
        f"{boxes}{known}\n</rts:RtsProfile>\n"
    )


MOVER = {"until": "M0=ERROR", "pose": "M0.pose", "goal": "M0.goal"}


@pytest.fixture(autouse=True)
def _project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", list(sys.path))
    (tmp_path / "src").mkdir()
    (tmp_path / "src" / "movers.py").write_text(MODULE)
    names = {
        "Mover": "Mover",
        "Ending": "Ending",
        "Printing": "Printing",
        "Broken": "Broken",
        "Waiting": "Waiting",
        "Hindered": "Hindered",
        "None": "no_component",
        "Raising": "raising",
    }
    lines = [f'{name} = "movers:{attribute}"\n' for name, attribute in names.items()]
    (tmp_path / "rtgen.toml").write_text(
        "[components]\n" + "".join(lines) + 'Gone = "nowhere_at_all:Gone"\n'
    )
    Path("m.xml").write_text(profile(("Mover", "M0"), **MOVER))
    yield
    sys.modules.pop("movers", None)


def test_the_report(capfd: pytest.CaptureFixture[str]) -> None:
    assert rtgen(["run", "m.xml"]) == 0
    out, err = capfd.readouterr()
    lines = out.splitlines()
    assert lines[0].split() == ["instance", "state", "ticks", "overruns", "lost"]
    assert lines[1].split() == ["M0", "finished", "200", "0", "0"]
    names = [line.partition("  ")[0] for line in lines[3:10]]
    assert names == [
        "goal",
        "final pose",
        "position error [m]",
        "heading error [rad]",
        "simulated [s]",
        "wall [s]",
        "ratio",
    ]
    assert lines[4].endswith("(2.0000, 0.0000, 6.2832)")
    assert lines[6].endswith(" 0.000000")
    assert lines[-1] == "M0: arrived"
    assert "M0 ACTIVE\n" in err


def test_quiet_and_machine_forms_show_no_progress(
    capfd: pytest.CaptureFixture[str],
) -> None:
    assert rtgen(["run", "m.xml", "--quiet"]) == 0
    assert capfd.readouterr().err == ""
    assert rtgen(["run", "m.xml", "--diagnostics", "json"]) == 0
    assert json.loads(capfd.readouterr().err) == []


@pytest.mark.parametrize(
    ("tolerance", "arguments", "exit_code", "said"),
    [
        # Steps of 0.3 m end 0.1 m beyond the goal.
        ("0.2", ["--set", "M0.speed=30"], 0, ""),
        ("0.05", ["--set", "M0.speed=30"], 1, "0.100 m from the goal, allowed 0.05 m"),
        ("0.2, 0.1", ["--set", "M0.speed=30"], 0, ""),
        ("0.05", ["--until", "M0=ERROR", "--set", "M0.speed=30"], 1, "0.100 m from"),
        # The condition is a section of the run, not its end.
        ("0.05", ["--until", "0.1"], 0, ""),
    ],
)
def test_a_run_that_ends_away_from_its_goal_has_failed(
    tolerance: str,
    arguments: list[str],
    exit_code: int,
    said: str,
    capfd: pytest.CaptureFixture[str],
) -> None:
    text = profile(("Mover", "M0"), **MOVER, tolerance=tolerance)
    Path("s.xml").write_text(text)
    assert rtgen(["run", "s.xml", *arguments]) == exit_code
    out = capfd.readouterr().out
    assert (f"the goal is not reached: {said}" in out) == bool(said)


def test_the_heading_at_the_end_counts_if_it_is_given(
    capfd: pytest.CaptureFixture[str],
) -> None:
    properties = MOVER | {"goal": "M0.turned", "tolerance": "0.05, 0.1"}
    Path("s.xml").write_text(profile(("Mover", "M0"), **properties))
    assert rtgen(["run", "s.xml"]) == 1
    assert "0.500 rad off the goal's heading, allowed 0.1 rad" in capfd.readouterr().out


def test_without_a_goal_at_the_end_a_tolerance_is_not_met(
    capfd: pytest.CaptureFixture[str],
) -> None:
    properties = MOVER | {"goal": "M0.nowhere", "tolerance": "0.05"}
    Path("s.xml").write_text(profile(("Mover", "M0"), **properties))
    assert rtgen(["run", "s.xml"]) == 1
    assert "no goal, or no pose, to judge the end by" in capfd.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "code", "ticks"),
    [
        (["--until", "0.5"], 0, "50"),
        (["--until", "M0=ERROR,0.5"], 1, "50"),
        (["--until", "M0=ACTIVE"], 0, "1"),
        (["--set", "M0.speed=4"], 0, "50"),
        (["--set", "M0.speed=4", "--set", "M0.distance=1"], 0, "25"),
    ],
)
def test_until_and_set(
    arguments: list[str], code: int, ticks: str, capfd: pytest.CaptureFixture[str]
) -> None:
    assert rtgen(["run", "m.xml", *arguments]) == code
    assert capfd.readouterr().out.splitlines()[1].split()[2] == ticks


def test_values_come_from_conf_files_then_the_system_then_the_command_line(
    capfd: pytest.CaptureFixture[str],
) -> None:
    def ticks(*arguments: str) -> int:
        assert rtgen(["run", "m.xml", *arguments]) == 0
        return int(capfd.readouterr().out.splitlines()[1].split()[2])

    assert ticks() == 200
    Path("Mover.conf").write_text("conf.default.speed: 2\nconf.default.distance: 4\n")
    assert ticks() == 200
    Path("M0.conf").write_text("conf.default.distance: 8\n")
    assert ticks() == 400
    sets = (
        '<rts:ConfigurationSets rts:id="default">'
        '<rts:ConfigurationData rts:name="speed" rts:data="4"/></rts:ConfigurationSets>'
    )
    Path("m.xml").write_text(profile(("Mover", "M0"), sets=sets, **MOVER))
    assert ticks() == 200
    assert ticks("--set", "M0.speed=8") == 100


def test_csv_plot_and_log(tmp_path: Path) -> None:
    files = {name: tmp_path / f"out.{name}" for name in ("csv", "svg", "log")}
    command = ["run", "m.xml", "--csv", str(files["csv"]), "--plot", str(files["svg"])]
    command += ["--log", str(files["log"])]
    assert rtgen(command) == 0
    first = {name: file.read_bytes() for name, file in files.items()}
    assert rtgen(command) == 0
    assert {name: file.read_bytes() for name, file in files.items()} == first
    rows = files["csv"].read_text().splitlines()
    assert rows[0] == "t,x,y,theta,goal_x,goal_y,goal_theta"
    assert rows[1].startswith("0.0,")
    assert rows[2].startswith("0.02,")
    events = [json.loads(line) for line in files["log"].read_text().splitlines()]
    changes = [(e["t"], e["from"], e["to"]) for e in events]
    assert changes[0] == (0, "INACTIVE_STATE", "ACTIVE_STATE")
    assert changes[1][1:] == ("ACTIVE_STATE", "ERROR_STATE")
    assert b"<svg" in first["svg"]


def test_a_folder_with_a_timeline(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "experiment"
    folder.mkdir()
    (folder / "system.xml").write_text(
        profile(("Mover", "M0"), until="1", pose="M0.pose")
    )
    (folder / "timeline.toml").write_text(
        '[[at]]\nt = 0.25\ndeactivate = "M0"\n[[at]]\nt = 0.5\nset = "M0.speed=2"\n'
        'activate = "M0"\n'
    )
    assert rtgen(["run", "experiment"]) == 0
    assert capfd.readouterr().out.splitlines()[1].split()[:3] == ["M0", "ACTIVE", "75"]


def test_a_component_is_reset(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "system.xml").write_text(profile(("Mover", "M0"), until="1"))
    timeline = tmp_path / "reset.toml"
    timeline.write_text(
        '[[at]]\nt = 0.5\nset = "M0.distance=100"\nreset = "M0"\n'
        '[[at]]\nt = 0.75\nactivate = "M0"\n'
    )
    command = ["run", str(tmp_path / "system.xml"), "--set", "M0.speed=20"]
    assert rtgen([*command, "--timeline", str(timeline)]) == 0
    assert capfd.readouterr().out.splitlines()[1].split()[:3] == ["M0", "ACTIVE", "35"]


def test_real_time(capfd: pytest.CaptureFixture[str]) -> None:
    assert rtgen(["run", "m.xml", "--clock", "real", "--set", "M0.speed=20"]) == 0
    assert capfd.readouterr().out.splitlines()[1].split()[1] == "finished"


@pytest.mark.parametrize(
    ("system", "arguments", "code"),
    [
        (profile(("Movr", "M0"), until="1"), [], "SYS0001"),
        (profile(("Broken", "M0"), until="1"), [], "SYS0002"),
        (profile(("None", "M0"), until="1"), [], "SYS0002"),
        (profile(("Raising", "M0"), until="1"), [], "SYS0021"),
        (profile(("Mover", "M0"), until="soon"), [], "SYS0006"),
        (profile(("Mover", "M0")), [], "SYS0006"),
        (profile(("Mover", "M0"), until="1"), ["--csv", "x.csv"], "SYS0008"),
        (profile(("Mover", "M0"), until="1", pose="M0.nose"), [], "SYS0008"),
        (profile(("Mover", "M0"), until="1", pose="N0.pose"), [], "SYS0005"),
        (profile(("Mover", "M0"), until="1"), ["--set", "M1.speed=1"], "SYS0005"),
        (profile(("Mover", "M0"), until="1"), ["--set", "M0.spee=1"], "SYS0004"),
        (profile(("Mover", "M0"), until="1"), ["--set", "M0.speed=-1"], "SYS0004"),
        (profile(("Mover", "M0"), until="1"), ["--set", "M0.speed=fast"], "SYS0004"),
        (
            profile(("Mover", "M0"), until="1").replace('Set="default"', 'Set="fast"'),
            [],
            "SYS0004",
        ),
        ("<junk", [], "RTC"),
    ],
)
def test_what_does_not_fit_is_refused(
    system: str, arguments: list[str], code: str, capfd: pytest.CaptureFixture[str]
) -> None:
    Path("m.xml").write_text(system)
    assert rtgen(["run", "m.xml", *arguments]) == 2
    out, err = capfd.readouterr()
    assert out == ""
    assert f"error[{code}" in err
    assert not Path("x.csv").exists()


def test_a_set_without_values_can_be_active(capfd: pytest.CaptureFixture[str]) -> None:
    sets = '<rts:ConfigurationSets rts:id="fast"/>'
    system = profile(("Mover", "M0"), sets=sets, until="1")
    Path("m.xml").write_text(system.replace('Set="default"', 'Set="fast"'))
    assert rtgen(["run", "m.xml"]) == 0, capfd.readouterr().err


@pytest.mark.parametrize(
    ("key", "name", "message"),
    [
        (
            "pose",
            "M0.speed",
            "rtgen.run.pose: M0.speed is not a pose: a pose has 3 values",
        ),
        ("goal", "M0.speed", "rtgen.run.goal: M0.speed is not a pose"),
        ("pose", "M0.broken", "ZeroDivisionError: division by zero"),
    ],
)
def test_an_observable_that_is_no_pose_is_reported_at_its_place(
    key: str, name: str, message: str, capfd: pytest.CaptureFixture[str]
) -> None:
    Path("m.xml").write_text(profile(("Mover", "M0"), until="1", **{key: name}))
    assert rtgen(["run", "m.xml"]) == 2
    err = capfd.readouterr().err
    assert re.search(r"^m.xml:\d+:\d+: error\[SYS0008\]: ", err, re.M)
    assert message in err


def test_an_observable_that_raises_in_the_run_ends_it(
    capfd: pytest.CaptureFixture[str],
) -> None:
    text = MODULE.replace("lambda: 1 / 0", "lambda: 1 / max(0.0, 1.0 - self.x)")
    Path("src/movers.py").write_text(text)
    Path("m.xml").write_text(profile(("Mover", "M0"), until="1.5"))
    assert rtgen(["run", "m.xml", "--csv", "M0.broken"]) == 1
    out, err = capfd.readouterr()
    assert "error[SYS0021]: the observable M0.broken at " in err
    assert "src/movers.py:" in err
    assert "M0" in out


@pytest.mark.parametrize(
    ("other", "code"), [("Broken", 2), ("Raising", 2), ("Gone", 3)]
)
def test_what_was_initialized_is_finalized_if_the_rest_fails(
    other: str, code: int, capfd: pytest.CaptureFixture[str]
) -> None:
    Path("m.xml").write_text(profile(("Ending", "M0"), (other, "O0"), until="1"))
    assert rtgen(["run", "m.xml"]) == code
    assert capfd.readouterr().err.count("finalized.") == 1


@pytest.mark.sampled(2)
@pytest.mark.parametrize("clock", ["sim", "real"])
@pytest.mark.parametrize("quiet", [[], ["-q"]])
def test_a_run_ends_when_nobody_reads_what_its_components_print(
    clock: str, quiet: list[str]
) -> None:
    Path("m.xml").write_text(profile(("Printing", "M0"), until="M0=CREATED"))
    command = [sys.executable, "-m", "rtgen", "run", "m.xml", "--clock", clock, *quiet]
    read, write = os.pipe()
    os.close(read)
    done = subprocess.run(
        command, stdout=write, stderr=subprocess.PIPE, text=True, timeout=60
    )
    os.close(write)
    assert done.returncode == 1
    assert done.stderr.count("finalized.") == 1
    for sign_of_a_fault in ("error[", "internal", "Traceback", "Exception ignored"):
        assert sign_of_a_fault not in done.stderr


def test_wrong_connections_parameters_and_conf_files_are_all_told(
    capfd: pytest.CaptureFixture[str],
) -> None:
    Path("Mover.conf").write_text("conf.default.sped: 2\n")
    sets = (
        '<rts:ConfigurationSets rts:id="default">'
        '<rts:ConfigurationData rts:name="lenght" rts:data="4"/></rts:ConfigurationSets>'
    )
    Path("m.xml").write_text(
        profile(("Mover", "M0"), ("Mover", "M1"), sets=sets, **MOVER)
    )
    assert rtgen(["run", "m.xml"]) == 2
    assert capfd.readouterr().err.count("error[SYS0004]") == 4


@pytest.mark.parametrize(
    ("set_id", "name", "data"),
    [
        ("default", "lenght", "4"),
        ("other", "lenght", "4"),
        ("default", "speed", "-1"),
        ("other", "speed", "fast"),
    ],
)
def test_a_wrong_parameter_of_a_set_is_one_error_at_its_place(
    set_id: str, name: str, data: str, capfd: pytest.CaptureFixture[str]
) -> None:
    wrong = f'<rts:ConfigurationData rts:name="{name}" rts:data="{data}"/>'
    sets = f'<rts:ConfigurationSets rts:id="{set_id}">\n{wrong}</rts:ConfigurationSets>'
    text = profile(("Mover", "M0"), sets=sets, **MOVER)
    text = text.replace('Set="default"', f'Set="{set_id}"')
    Path("m.xml").write_text(text)
    assert rtgen(["run", "m.xml"]) == 2
    line = next(n for n, t in enumerate(text.splitlines(), 1) if wrong in t)
    err = capfd.readouterr().err
    assert err.count("error[") == 1
    assert f"m.xml:{line}:34: error[SYS0004]" in err


@pytest.mark.parametrize(
    "arguments",
    [
        ["--csv", "m.xml/x.csv"],
        ["--log", "m.xml/more/x.log"],
        ["--plot", "m.xml/x.svg"],
        ["--record", "m.xml/x.mcap"],
        ["--plot", "x.bmp"],
    ],
)
def test_files_that_cannot_be_written_end_it_before_the_run(
    arguments: list[str], capfd: pytest.CaptureFixture[str]
) -> None:
    assert rtgen(["run", "m.xml", *arguments]) == 3
    out, err = capfd.readouterr()
    assert out == ""
    assert "error[ENV0001]" in err
    assert "M0 ACTIVE" not in err


def test_two_results_in_one_file(capfd: pytest.CaptureFixture[str]) -> None:
    assert rtgen(["run", "m.xml", "--csv", "a.csv", "--log", "./a.csv"]) == 2
    assert "--csv and --log both write ./a.csv" in capfd.readouterr().err
    assert not Path("a.csv").exists()
    assert rtgen(["run", "m.xml", "--csv", "/dev/null", "--log", "/dev/null"]) == 0


@pytest.mark.parametrize("option", ["--csv", "--log", "--plot", "--record"])
def test_missing_folders_are_made(option: str) -> None:
    suffix = {"--csv": "csv", "--log": "log", "--plot": "svg", "--record": "mcap"}
    file = Path("results", "today", f"x.{suffix[option]}")
    assert rtgen(["run", "m.xml", option, str(file)]) == 0
    assert file.stat().st_size > 0


def test_a_missing_extra_ends_it_before_the_run(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("rtgen.tools.running.trajectory.find_spec", lambda name: None)
    assert rtgen(["run", "m.xml", "--plot", "x.svg"]) == 3
    assert (
        "pip install ./runtime '.[plot]' in a clone of rtgen" in capfd.readouterr().err
    )


def test_a_factory_that_cannot_be_imported(capfd: pytest.CaptureFixture[str]) -> None:
    Path("m.xml").write_text(profile(("Gone", "G0"), until="1"))
    assert rtgen(["run", "m.xml"]) == 3
    assert "nowhere_at_all" in capfd.readouterr().err


def test_factories_of_the_generated_package(capfd: pytest.CaptureFixture[str]) -> None:
    Path("rtgen.toml").write_text("")
    manifest = Path("generated/.rtgen.json")
    manifest.parent.mkdir()
    manifest.write_text('{"factories": {"Mover": "movers:Mover"}}')
    assert rtgen(["run", "m.xml"]) == 0
    assert "arrived" in capfd.readouterr().out


@pytest.mark.parametrize("text", ["{", '{"factories": ["Mover"]}', "[" * 100_000])
def test_a_damaged_manifest(text: str, capfd: pytest.CaptureFixture[str]) -> None:
    Path("rtgen.toml").write_text("")
    manifest = Path("generated/.rtgen.json")
    manifest.parent.mkdir()
    manifest.write_text(text)
    assert rtgen(["run", "m.xml"]) == 3
    said = capfd.readouterr().err
    assert "cannot read generated/.rtgen.json" in said
    assert "run rtgen generate" in said


def interrupted(number: signal.Signals, *arguments: str) -> tuple[int, str, str]:
    """Return exit code and output of a command that is interrupted while a component is ACTIVE."""
    process = subprocess.Popen(
        [sys.executable, "-m", "rtgen", *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert process.stderr is not None
    assert any(line.endswith("M0 ACTIVE\n") for line in process.stderr)
    process.send_signal(number)
    out, err = process.communicate(timeout=PATIENCE)
    return process.returncode, out, err


@pytest.mark.sampled(3)
@pytest.mark.parametrize("clock", ["sim", "real"])
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize(
    ("until", "before"),
    [("100000000", " of 1e+08 s"), ("M0=ERROR,100000000", ", before M0=ERROR")],
)
def test_an_interrupt_ends_a_run_with_its_report(
    number: signal.Signals, clock: str, until: str, before: str
) -> None:
    command = ("run", "m.xml", "--clock", clock, "--until", until)
    code, out, err = interrupted(number, *command, "--set", "M0.distance=1e12")
    assert code == 130, err
    assert re.search(rf"^interrupted at \d+\.\d{{3}} s{re.escape(before)}$", err, re.M)
    assert out.startswith("instance")
    assert "Traceback" not in err


@pytest.mark.sampled(1)
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupt_is_the_end_of_a_run_without_a_condition(
    number: signal.Signals,
) -> None:
    Path("s.xml").write_text(profile(("Mover", "M0")))
    code, out, err = interrupted(number, "run", "s.xml", "--clock", "real")
    assert code == 0, err
    assert "interrupted" not in err
    assert out.startswith("instance")


def test_what_hinders_an_active_component_is_reported(
    capfd: pytest.CaptureFixture[str],
) -> None:
    Path("s.xml").write_text(profile(("Hindered", "H0"), ("Hindered", "H1")))
    assert rtgen(["run", "s.xml", "--until", "2"]) == 0
    assert capfd.readouterr().out.endswith("\n\nH0: no scan for 0.5 s\n")


def test_what_is_waited_for_is_reported(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    system = tmp_path / "waiting.xml"
    system.write_text(profile(("Waiting", "W0")), encoding="utf-8")
    assert rtgen(["run", str(system), "--until", "0.5"]) == 0
    out = capsys.readouterr().out
    assert "W0: waits for a second to pass" in out
    assert rtgen(["run", str(system), "--until", "W0=ACTIVE"]) == 0
    shown = capsys.readouterr()
    assert "waits" not in shown.out
    assert "W0 ACTIVE" in shown.err
