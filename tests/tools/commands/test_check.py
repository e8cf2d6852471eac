"""`rtgen check`: everything that can be checked without a run, each at its place."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
from msgspec.structs import replace

from rtgen.cli import run
from rtgen.compiler.diagnostics import Severity
from rtgen.compiler.frontends.kit.memo import Memo
from rtgen.compiler.lint import rules as lint_rules
from rtgen.compiler.project import load
from rtgen.compiler.project.output import MANIFEST, Change, plan
from rtgen.tools.compiling.cached import build
from rtgen.tools.compiling.checking import Part
from rtgen.tools.indexing import reading

IDL = """\
// Two structs, an enum, a service and two components.
module Kitchen {
    enum Mode { OFF, BAKE };

    struct Temperature {
        double value;
        Mode state;
    };

    struct Power {
        double value;
    };

    interface Timer {
        boolean start(in double seconds);
    };
};

component Oven {
    publishes Kitchen::Temperature warmth;
    consumes Kitchen::Power current;
    provides Kitchen::Timer clock;
    attribute double gain;
};

component Thermostat {
    consumes Kitchen::Temperature measured;
    publishes Kitchen::Power current;
    uses Kitchen::Timer clock;
    attribute double target;
};
"""
FILE = "idl/kitchen.idl"
PROJECT = '[sources]\npaths = ["idl"]\n[output]\npackage = "kitchen"\n'
LINES = {
    name: IDL[: IDL.index(f"{name} {{")].count("\n") + 1
    for name in ("Mode", "Temperature", "Power", "Timer", "Oven", "Thermostat")
}
"""The line of each declaration."""


@pytest.fixture(autouse=True)
def _project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("RTGEN_CACHE_DIR", str(tmp_path / "cache"))
    Path("idl").mkdir()
    Path(FILE).write_text(IDL)
    Path("rtgen.toml").write_text(PROJECT)
    assert run(["generate", "-q"]) == 0


def findings(
    capfd: pytest.CaptureFixture[str], *options: str, code: int = 1
) -> list[dict[str, object]]:
    """Return the findings of a check, which ends with an exit code."""
    capfd.readouterr()
    assert run(["check", "--diagnostics", "json", *options]) == code
    out: list[dict[str, object]] = json.loads(capfd.readouterr().err)
    return out


def change(old: str, new: str, file: str = FILE, count: int = -1) -> None:
    text = Path(file).read_text()
    assert old in text
    Path(file).write_text(text.replace(old, new, count))


def test_nothing_is_found(capfd: pytest.CaptureFixture[str]) -> None:
    assert run(["check"]) == 0
    assert capfd.readouterr() == ("", "")


CHANGES = {
    "an enumerator": ("OFF, BAKE", "OFF, BAKE, GRILL", {"Mode"}),
    "a new member": ("Mode state;", "Mode state; long count;", {"Temperature"}),
    "a member of another type": ("double value;\n    };", "float value;\n    };", {"Power"}),
    "two": ("double value", "float number", {"Temperature", "Power"}),
    "a renamed member": ("double value;\n    };", "double watts;\n    };", {"Power"}),
    "an operation": ("boolean start", "boolean begin", {"Timer"}),
    "an argument": ("in double seconds", "in float seconds", {"Timer"}),
    "a renamed port": ("Temperature warmth", "Temperature heat", {"Oven"}),
    "another port": ("measured;", "seen;", {"Thermostat"}),
    "a parameter": ("double gain", "double factor", {"Oven"}),
    "a service": ("uses Kitchen::Timer clock", "uses Kitchen::Timer alarm", {"Thermostat"}),
    "a comment": ("component Oven", "/** Bakes. */ component Oven", {"Oven"}),
    "a renamed component": ("component Oven", "component Stove", {"Stove"}),
    "a new struct": ("    interface", "    struct Added { long a; };\n    interface", {"Added"}),
}  # fmt: skip


@pytest.mark.sampled(4)
@pytest.mark.parametrize("cached", [True, False])
@pytest.mark.parametrize("kind", CHANGES)
def test_drift_is_at_the_declaration(
    kind: str, cached: bool, capfd: pytest.CaptureFixture[str]
) -> None:
    old, new, names = CHANGES[kind]
    change(old, new)
    options = [] if cached else ["--no-cache"]
    drift = [f for f in findings(capfd, *options) if f["code"] == "PRJ0017"]
    again = [f for f in findings(capfd, *options) if f["code"] == "PRJ0017"]
    assert drift == again
    text = Path(FILE).read_text().split("\n")
    here = [f for f in drift if "no longer" not in str(f["message"])]
    assert {f["line"] for f in here} == {
        next(n for n, line in enumerate(text, 1) if f"{name} {{" in line)
        for name in names
    }
    assert {f["file"] for f in drift} == {FILE}
    assert {f["severity"] for f in drift} == {"error"}
    assert not [f for f in drift if ".rtgen.json" in str(f["message"])]
    files = {str(f["message"]).split(" ")[0] for f in drift}
    planned = {str(c.path) for c in _differences()}
    assert files == planned


def _differences() -> list[Change]:
    project = load()
    return [
        replace(each, path=each.path.relative_to(project.root))
        for each in plan(project, build(project, None)).changes
        if each.path.name != MANIFEST
    ]


def test_each_stray_or_left_file_is_reported_at_itself(
    capfd: pytest.CaptureFixture[str],
) -> None:
    Path("generated/notes.txt").write_text("mine\n")
    Path("generated/.rtgen-77.tmp").write_text("")
    reported = {f["file"]: f["code"] for f in findings(capfd)}
    assert reported == {
        "generated/notes.txt": "PRJ0018",
        "generated/.rtgen-77.tmp": "PRJ0017",
    }


def test_the_manifest_alone_is_reported_in_words(
    capfd: pytest.CaptureFixture[str],
) -> None:
    manifest = Path("generated/.rtgen.json")
    good = manifest.read_text()
    Path(FILE).write_text(f"{IDL}// the end\n")
    [finding] = findings(capfd)
    assert finding["message"] == (
        "idl/kitchen.idl has changed since the last rtgen generate; no generated file differs"
    )
    assert run(["check"]) == 1
    assert "sha256" not in "".join(capfd.readouterr())
    Path(FILE).write_text(IDL)
    for text, words in {
        good.replace("rtgen 0", "rtgen 9", 1): "generated by rtgen 9",
        good[:-3]: "generated/.rtgen.json is missing or damaged",
        "[]": "generated/.rtgen.json is missing or damaged",
        good.replace("components", "component", 1): "generated/.rtgen.json is out of",
    }.items():
        manifest.write_text(text)
        [finding] = findings(capfd)
        assert str(finding["message"]).startswith(words)
        assert (finding["file"], finding["line"]) == (FILE, 1)
    manifest.unlink()
    [finding] = findings(capfd)
    assert finding["message"] == "generated/.rtgen.json is missing or damaged"


def test_changes_by_hand_are_told_from_changes_of_definitions(
    capfd: pytest.CaptureFixture[str],
) -> None:
    base = "generated/kitchen/components/oven/__init__.py"
    change("gain", "factor", base)
    [finding] = findings(capfd)
    assert finding["message"] == f"{base} was changed after it was generated"
    assert (finding["file"], finding["line"]) == (FILE, LINES["Oven"])


def test_differences_are_short(capfd: pytest.CaptureFixture[str]) -> None:
    change("double target;", "".join(f"attribute double a{n};" for n in range(60))[10:])
    Path("generated/kitchen/components/oven/RTC.xml").unlink()
    assert run(["check"]) == 1
    out = capfd.readouterr().out
    assert len(out.splitlines()) < 60
    assert max(map(len, out.splitlines())) < 200
    assert "+    a0: float = parameter(0.0)\n" in out
    assert "more lines, see rtgen generate --diff\n" in out
    assert "+++ b/generated/kitchen/components/oven/RTC.xml\n---" in out


SYSTEM = """\
<?xml version="1.0" encoding="UTF-8"?>
<rts:RtsProfile rts:id="RTSystem:k:Kitchen:1" rts:version="0.2"
    xmlns:rts="http://www.openrtp.org/namespaces/rts"
    xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance">
  <rts:Components rts:instanceName="Oven0" rts:id="RTC:::Oven:1.0.0" rts:pathUri=""
      rts:isRequired="true" rts:activeConfigurationSet="default">
    <rts:ConfigurationSets rts:id="default">
      <rts:ConfigurationData rts:name="gain" rts:data="2.0"/>
    </rts:ConfigurationSets>
  </rts:Components>
  <rts:Components rts:instanceName="Thermostat0" rts:id="RTC:::Thermostat:1.0.0"
      rts:pathUri="" rts:isRequired="true"/>
  <rts:DataPortConnectors rts:name="heat" rts:connectorId="1" rts:interfaceType="direct"
      rts:dataType="Kitchen::Temperature" rts:dataflowType="push" rts:subscriptionType="flush">
    <rts:sourceDataPort rts:componentId="RTC:::Oven:1.0.0" rts:instanceName="Oven0"
        rts:portName="warmth"/>
    <rts:targetDataPort rts:componentId="RTC:::Thermostat:1.0.0"
        rts:instanceName="Thermostat0" rts:portName="measured"/>
  </rts:DataPortConnectors>
</rts:RtsProfile>
"""
KITCHEN = "systems/system.xml"
TIMELINE = "systems/timeline.toml"
OVEN = "src/oven.py"
ORDER = [part.value for part in Part]


@pytest.fixture
def system() -> None:
    """Add a system with a timeline, and find nothing."""
    Path("systems").mkdir()
    Path(KITCHEN).write_text(SYSTEM)
    Path(TIMELINE).write_text('[[at]]\nt = 1\nset = "Oven0.gain=3"\n')
    Path("rtgen.toml").write_text(PROJECT.replace('"idl"', '"idl", "systems"'))
    assert run(["check"]) == 0


FAULTS = {
    "a port that is not there": (KITCHEN, '"warmth"', '"warmht"', "RTC0581", 2, 16, "systems"),
    "a parameter that is not there": (KITCHEN, '"gain"', '"gian"', "RTC0586", 2, 8, "systems"),
    "a value of another type": (KITCHEN, '"2.0"', '"two"', "RTC0586", 2, 8, "systems"),
    "an active set": (KITCHEN, 'Set="default"', 'Set="fast"', "RTC0599", 1, 5, "systems"),
    "a component": (KITCHEN, "Oven:1.0.0", "Ovn:1.0.0", "RTC0580", 2, 5, "systems"),
    "wiring of two types": (KITCHEN, '"measured"', '"current"', "RTC0582", 2, 18, "systems"),
    "XML": (KITCHEN, "</rts:RtsProfile>", "", None, 2, None, "systems"),
    "an event in vain": (TIMELINE, "Oven0", "Oven1", "SYS0027", 1, 3, "timelines"),
    "TOML": (TIMELINE, "[[at]]", "[[at]", "SYS0007", 2, 1, "timelines"),
    "a behaviour": (OVEN, "on_execute", "on_excute", "PRJ0014", 1, 35, "behaviours"),
}  # fmt: skip


@pytest.mark.sampled(3)
@pytest.mark.parametrize("kind", FAULTS)
@pytest.mark.usefixtures("system")
def test_faults_are_found_at_their_lines(
    kind: str, capfd: pytest.CaptureFixture[str]
) -> None:
    file, old, new, rule, code, line, part = FAULTS[kind]
    change(old, new, file)
    found = findings(capfd, code=code)
    assert {f["file"] for f in found} == {file}
    if rule is not None:
        assert (rule, line) in {(f["code"], f["line"]) for f in found}
    assert findings(capfd, "--only", part, code=code) == found
    assert findings(capfd, "--no-cache", code=code) == found
    others = [word for each in ORDER if each != part for word in ("--only", each)]
    assert findings(capfd, *others, code=0) == []
    change(new, old, file)
    assert findings(capfd, code=0) == []


@pytest.mark.parametrize("command", ["inspect", "graph"])
@pytest.mark.usefixtures("system")
def test_commands_that_only_read_a_system_warn_of_its_configuration(
    command: str, capfd: pytest.CaptureFixture[str]
) -> None:
    change('"gain"', '"gian"', KITCHEN)
    change('Set="default"', 'Set="fast"', KITCHEN)
    assert run([command, KITCHEN]) == 0
    err = capfd.readouterr().err
    assert "system.xml:8:40: warning[RTC0586]: Oven has no parameter 'gian'" in err
    assert "warning[RTC0599]: Oven0 has no configuration set 'fast'" in err
    Path("systems/Oven.conf").write_text("conf.fast.gain: 3\n")
    assert run([command, KITCHEN]) == 0
    assert "RTC0599" not in capfd.readouterr().err


@pytest.mark.parametrize("command", ["inspect", "graph"])
@pytest.mark.usefixtures("system")
def test_a_system_is_read_with_the_project_around_it(
    command: str,
    tmp_path_factory: pytest.TempPathFactory,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    change('"gain"', '"gian"', KITCHEN)
    system = Path(KITCHEN).absolute()
    monkeypatch.chdir(tmp_path_factory.mktemp("elsewhere"))
    assert run([command, str(system)]) == 0
    assert "Oven has no parameter 'gian'" in capfd.readouterr().err


CONFS = {
    "a parameter that is not there": "conf.default.gian: 3",
    "a value of another type": "conf.default.gain: two",
    "a line of another form": "conf.default.gain 3",
    "a key of another form": "conf.gain: 3",
    "a rate": "exec_cxt.periodic.rate: fast",
    "an active set": "configuration.active_config: fast",
}


@pytest.mark.parametrize("kind", CONFS)
@pytest.mark.usefixtures("system")
def test_check_and_run_find_faults_of_conf_files_at_their_lines(
    kind: str, capfd: pytest.CaptureFixture[str]
) -> None:
    Path("systems/Oven.conf").write_text(f"# the oven\n{CONFS[kind]}\n")
    assert run(["check"]) == 1
    err = capfd.readouterr().err
    assert "systems/Oven.conf:2:1: warning[RTC0599]: " in err
    assert f"2 | {CONFS[kind]}" in err
    assert err.count("RTC0599") == 1
    assert run(["run", KITCHEN, "--until", "0.1"]) == 2
    assert "systems/Oven.conf:2:1: error[SYS0004]: " in capfd.readouterr().err


UNITS = {
    "dimensions": ('@unit("degC")', '@unit("W")', "RTC0593", "error", 2),
    "scales": ('@unit("K")', '@unit("mK")', "RTC0595", "warning", 1),
}


@pytest.mark.parametrize("kind", UNITS)
@pytest.mark.usefixtures("system")
def test_units_of_connected_ports(kind: str, capfd: pytest.CaptureFixture[str]) -> None:
    sent, received, rule, severity, code = UNITS[kind]
    change("publishes Kitchen::Temperature", f"{sent} publishes Kitchen::Temperature")
    change("consumes Kitchen::Temperature", f"{received} consumes Kitchen::Temperature")
    assert run(["generate", "-q"]) == 0
    [finding] = findings(capfd, "--only", "units", code=code)
    assert (finding["code"], finding["severity"]) == (rule, severity)
    assert (finding["file"], finding["line"]) == (KITCHEN, 13)
    assert findings(capfd, "--only", "systems", code=0) == []


def test_a_misspelt_unit_is_found(capfd: pytest.CaptureFixture[str]) -> None:
    Path(FILE).write_text(
        IDL.replace(
            "    attribute double target",
            '    @unit("celcius") attribute double target',
        )
    )
    assert run(["generate", "-q"]) == 0
    for words in (["--only", "units"], [], ["--no-cache"]):
        capfd.readouterr()
        assert run(["check", *words]) == 1
        err = capfd.readouterr().err
        assert f"{FILE}:{LINES['Thermostat'] + 4}:" in err
        assert "warning[LINT0024]: 'celcius' is not a unit" in err
    assert run(["check", "--only", "lint", "--only", "systems"]) == 0
    assert "LINT0024" not in capfd.readouterr().err


@pytest.mark.usefixtures("system")
def test_a_new_system_module_or_timeline_is_checked_at_once(
    capfd: pytest.CaptureFixture[str],
) -> None:
    """Whatever an earlier check has left in the cache."""
    Path("systems/second.xml").write_text(SYSTEM.replace("warmth", "warmht"))
    assert {f["file"] for f in findings(capfd, code=2)} == {"systems/second.xml"}
    Path("systems/second.xml").unlink()
    Path("src/other.py").write_text(
        "from kitchen.components.stove import StoveBase\nclass S(StoveBase): ...\n"
    )
    assert {f["file"] for f in findings(capfd)} == {"src/other.py"}
    Path("src/other.py").unlink()
    Path(TIMELINE).write_text('follows = "first.toml"\n')
    assert [f["code"] for f in findings(capfd, code=2)] == ["SYS0007"]
    Path("systems/first.toml").write_text('[[at]]\nt = 1\nset = "Oven0.gain=3"\n')
    assert findings(capfd, code=0) == []
    Path("systems/first.toml").write_text('[[at]]\nt = 1\nset = "Oven7.gain=3"\n')
    assert [f["file"] for f in findings(capfd)] == ["systems/first.toml"]


@pytest.mark.usefixtures("system")
def test_parts_are_reported_in_order(capfd: pytest.CaptureFixture[str]) -> None:
    for kind in ("a port that is not there", "an event in vain", "a behaviour"):
        file, old, new, *_ = FAULTS[kind]
        change(old, new, file)
    change("double gain", "double gain; attribute double more")
    capfd.readouterr()
    assert run(["check", "--diagnostics", "github"]) == 2
    codes = re.findall(r"title=(\w+)", capfd.readouterr().err)
    assert [*dict.fromkeys(codes)] == ["PRJ0017", "RTC0581", "SYS0027", "PRJ0014"]


@pytest.mark.usefixtures("system")
def test_findings_of_check_can_be_ignored(capfd: pytest.CaptureFixture[str]) -> None:
    change("on_execute", "on_excute", OVEN)
    assert len(findings(capfd)) == 1
    toml = Path("rtgen.toml").read_text()
    Path("rtgen.toml").write_text(f'{toml}[lint]\nignore = ["PRJ0014"]\n')
    assert findings(capfd, code=0) == []


@pytest.mark.usefixtures("system")
def test_no_code_of_the_user_is_executed(capfd: pytest.CaptureFixture[str]) -> None:
    text = Path(OVEN).read_text()
    Path(OVEN).write_text(f'{text}\n\nopen("executed", "w").write("")\n')
    for options in ([], ["--no-cache"]):
        assert findings(capfd, *options, code=0) == []
    assert not Path("executed").exists()


def test_no_builtin_rule_of_lint_is_an_error() -> None:
    """So `rtgen check` runs those of plug-ins only."""
    assert Severity.ERROR not in {rule.severity for rule in lint_rules.RULES}


@pytest.mark.usefixtures("system")
def test_a_host_shows_each_fault_at_its_line(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    """Drift, a broken system, units in conflict, a renamed port, in a part of a repository."""
    Path("src/thermostat.py").write_text(
        "from kitchen.components.thermostat import ThermostatBase\n\n\n"
        "class Thermostat(ThermostatBase):\n    def on_execute(self, ec_id):\n"
        "        measured = self.measured.read()\n        return 0\n"
    )
    Path("systems/units.xml").write_text(SYSTEM.replace('"measured"', '"seen"'))
    change(
        "publishes Kitchen::Temperature", '@unit("degC") publishes Kitchen::Temperature'
    )
    change(
        "consumes Kitchen::Temperature measured",
        '@unit("W") consumes Kitchen::Temperature seen',
    )
    monkeypatch.setenv("GITHUB_WORKSPACE", str(Path.cwd().parent))
    capfd.readouterr()
    assert run(["check", "--diagnostics", "github"]) == 2
    lines = capfd.readouterr().err.splitlines()
    form = r"::(\w+) file=(.*?),line=(\d+),col=\d+,endLine=\d+,endColumn=\d+,title=(\w+)::.+"
    matches = [re.fullmatch(form, line) for line in lines]
    places = {m.groups() for m in matches if m is not None}
    assert None not in matches
    assert places == {
        (level, f"{Path.cwd().name}/{file}", str(line), code)
        for level, file, line, code in (
            ("error", FILE, LINES["Oven"], "PRJ0017"),
            ("error", FILE, LINES["Thermostat"], "PRJ0017"),
            ("error", KITCHEN, 18, "RTC0581"),
            ("error", "systems/units.xml", 13, "RTC0593"),
            ("warning", "src/thermostat.py", 6, "PRJ0013"),
        )
    }


@pytest.mark.usefixtures("system")
def test_every_reader_of_a_system_judges_its_timeline(
    capfd: pytest.CaptureFixture[str],
) -> None:
    Path(TIMELINE).write_text('[[at]]\nt = 1\nset = "Oven0.gian=3"\n')
    expected = ("SYS0004", TIMELINE, 3)
    for words in (
        ["check"],
        ["lint"],
        ["inspect", FILE, KITCHEN],
        ["inspect", KITCHEN],
    ):
        capfd.readouterr()
        run([*words, "--diagnostics", "json"])
        found = json.loads(capfd.readouterr().err)
        assert expected in [(d["code"], d["file"], d["line"]) for d in found], words
    project = load(Path.cwd())
    of_editor = reading.read(project, Memo(), texts={}).of_systems
    assert expected in [(d.code, d.span.file, d.span.line) for d in of_editor if d.span]


CALLER = """\
from kitchen.components.thermostat import ThermostatBase


class Thermostat(ThermostatBase):
    def on_execute(self, ec_id):
        return self.clock.start(1.0) and 0
"""


@pytest.mark.usefixtures("system")
def test_a_consumer_without_a_provider(capfd: pytest.CaptureFixture[str]) -> None:
    assert findings(capfd, code=0) == []  # no behaviour uses it
    Path("src/thermostat.py").write_text(CALLER)
    [finding] = findings(capfd, code=1)
    assert (finding["code"], finding["file"]) == ("RTC0598", KITCHEN)
    text = Path("rtgen.toml").read_text()
    Path("rtgen.toml").write_text(f'{text}\n[ros2]\nnode = "kitchen"\n')
    assert run(["generate", "-q"]) == 0
    assert findings(capfd, "--only", "systems", code=0) == []
