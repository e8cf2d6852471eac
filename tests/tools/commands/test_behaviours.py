"""Renamed components and ports: the old behaviour file and old uses are reported."""

from __future__ import annotations

import json
from pathlib import Path
from textwrap import indent

import pytest
from user_project import CONTROLLER, write

from rtgen.cli import run
from rtgen.compiler.project import behaviour_callbacks

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


def test_the_behaviour_of_a_renamed_component_stays(
    capfd: pytest.CaptureFixture[str],
) -> None:
    _rename("component Controller", "component Controllers")
    assert run(["generate", "--diagnostics", "json"]) == 0
    [finding] = _findings(capfd)
    assert (finding["code"], finding["severity"]) == ("PRJ0012", "warning")
    assert (finding["file"], finding["line"], finding["column"]) == (CONTROLLER, 6, 24)
    command = "rtgen generate --rename Controller=Controllers"
    assert finding["hint"] == f"was it renamed to Controllers? {command}"
    assert not Path(CONTROLLER).with_stem("controllers").exists()
    for command in ("check", "generate"):
        run([command, "--diagnostics", "json"])
        assert _findings(capfd) == [finding]
    assert Path(CONTROLLER).exists()
    assert not Path(CONTROLLER).with_stem("controllers").exists()


def test_a_renamed_port_is_still_used(capfd: pytest.CaptureFixture[str]) -> None:
    _rename("publishes Heating::Power power", "publishes Heating::Power powers")
    assert run(["generate", "-q"]) == 0
    err = capfd.readouterr().err
    assert (
        f"{CONTROLLER}:18:18: warning[PRJ0013]: the definition has no port 'power'"
        in err
    )
    assert "rtgen generate --rename Controller.power=powers" in err
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


@pytest.mark.parametrize(
    ("text", "code", "line", "severity"),
    [
        ("def f(:\n", "PRJ0024", 1, "error"),
        ("x = 1\n\ny = 'unclosed\n", "PRJ0024", 3, "error"),
        ("if x:\npass\n", "PRJ0024", 2, "error"),
        ("x = '\0'\n", "PRJ0024", 1, "error"),
        ("class Controler: ...\n", "PRJ0025", 1, "warning"),
        ("", "PRJ0025", 1, "warning"),
    ],
)
def test_a_module_that_no_run_can_use(
    text: str, code: str, line: int, severity: str, capfd: pytest.CaptureFixture[str]
) -> None:
    Path(CONTROLLER).write_text(text)
    assert run(["check", "--diagnostics", "json"]) == (2 if severity == "error" else 1)
    [finding] = _findings(capfd)
    assert (finding["code"], finding["severity"]) == (code, severity)
    assert (finding["file"], finding["line"]) == (CONTROLLER, line)


@pytest.mark.parametrize(
    "text",
    [
        "class Controller: ...\n",
        "from elsewhere import Controller\n",
        "from elsewhere import *\n",
        "Controller = make()\n",
        "def Controller(name): ...\n",
        "if True:\n    class Controller: ...\n",
    ],
)
def test_a_behaviour_is_whatever_has_its_name(text: str) -> None:
    Path(CONTROLLER).write_text(text)
    assert run(["check", "--only", "behaviours"]) == 0


def test_a_behaviour_that_does_not_exist_is_created_or_named(
    capfd: pytest.CaptureFixture[str],
) -> None:
    Path(CONTROLLER).unlink()
    assert run(["check"]) == 1
    err = capfd.readouterr().err
    assert f"warning[PRJ0025]: {CONTROLLER}, the behaviour of Controller" in err
    assert "rtgen generate creates its skeleton" in err
    with Path("rtgen.toml").open("a") as settings:
        settings.write('\n[components]\nController = "elsewhere:Controller"\n')
    assert run(["check", "--only", "behaviours"]) == 0


KITCHEN = """\
module Kitchen {
    enum Mode { OFF, BAKE };
    struct Heat { double value; Mode state; };
    interface Timer { boolean start(in double seconds); };
};
component Oven {
    publishes Kitchen::Heat warmth;
    consumes Kitchen::Heat wanted;
    uses Kitchen::Timer clock;
    provides Kitchen::Timer bell;
    attribute double gain;
};
"""
HEAD = """\
from __future__ import annotations

from myrobot import kitchen
from myrobot.components.oven import OvenBase
from myrobot.kitchen import Heat, Mode
from rtgen.runtime import RTC_OK, ReturnCode_t

"""


@pytest.fixture
def oven(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A project with a component of every kind of declaration; return its behaviour."""
    folder = tmp_path / "kitchen"
    (folder / "idl").mkdir(parents=True)
    monkeypatch.chdir(folder)
    Path("idl/kitchen.idl").write_text(KITCHEN)
    Path("rtgen.toml").write_text(
        '[sources]\npaths = ["idl"]\n[output]\npackage = "myrobot"\n'
    )
    assert run(["generate", "-q"]) == 0
    return Path("src/oven.py")


def _uses(file: Path, text: str, capfd: pytest.CaptureFixture[str]) -> list[str]:
    """Return the words at the places of the findings of a check of a module with an Oven."""
    file.write_text(text if "class Oven" in text else f"{text}\n\nclass Oven: ...\n")
    capfd.readouterr()
    code = run(["check", "--only", "behaviours", "--diagnostics", "json"])
    findings = _findings(capfd)
    lines = text.split("\n")
    assert code == bool(findings)
    assert {f["code"] for f in findings} <= {"PRJ0013"}
    return [
        lines[f["line"] - 1][f["column"] - 1 : f["end_column"] - 1]  # type: ignore[operator]
        for f in findings
    ]


IN_A_METHOD = {
    # what stands in on_execute: the words that are reported
    "warmth = self.warmht.write(Heat())": ["warmht"],
    "warmht = 1; self.warmht.write(Heat())": ["warmht"],
    "out = self.warmht; out.write(Heat())": ["warmht"],
    "'é'; self.wantd.read()": ["wantd"],
    "return self.wantd.is_new() and RTC_OK": ["wantd"],
    "self.clok.start(1.0)": ["clok"],
    "self.clock.begin(1.0)": ["begin"],
    "self.clock.object.begin(1.0)": ["begin"],
    "timer = self.clock.object; timer.begin(1.0)": ["begin"],
    "self.bel.set_servant(self)": ["bel"],
    "self.config.gian": ["gian"],
    "config = self.config; config.gian": ["gian"],
    "config = (self.config)\n        config.gian": ["gian"],
    "config = self.config  # of it\n        config.gian": ["gian"],
    "config = (\n            self.config\n        ); config.gian": ["gian"],
    "self\\\n            .warmht.write(Heat())": ["warmht"],
    "self.config.gian = 2.0": ["gian"],
    "self.warmth.reed()": ["reed"],
    "list(map(lambda x: self.warmht, []))": ["warmht"],
    "print([self.gone for _ in ()])": ["gone"],
    "kitchen.Heta()": ["Heta"],
    "kitchen.Mode.OFF": [],
    "self.warmth.write(Heat()); self.wanted.read(); self.clock.start(1.0)": [],
    "self.clock.object.start(1.0); self.bell.set_servant(None)": [],
    "self.config.gain; self.instance_name; self.__class__; self.folder": [],
    "self.count = 1; self.count += 1; print(self.count)": [],
    "self.first, self.second = 1, 2; print(self.first + self.second)": [],
    "config = self.config; config = object(); config.gian": [],
    "config = self.config\n        for config in (): config.gian": [],
    "(lambda self: self.anything)(kitchen)": [],
    "kitchen = object(); kitchen.Heta": [],
    "self = object(); self.anything": [],
    "setattr(self, 'late', 1); self.late": [],
    "self.__dict__['late'] = 1; self.late": [],
    "self.made_below()": [],
    "self.CLASS_LEVEL, self.noted": ["noted"],
    "heat = kitchen.Heat(); self.stamp(heat)": ["heat"],
    "self.stamp(Heat())": ["Heat"],
    "heat = Heat(); heat = self.made_below(); self.stamp(heat)": [],
    "heat = self.warmth; self.stamp(heat)": [],
    "for heat in [Heat()]: self.stamp(heat)": [],
    "other = self; other.stamp(Heat())": [],
}


@pytest.mark.sampled(12)
@pytest.mark.parametrize("statement", IN_A_METHOD)
def test_uses_in_methods(
    statement: str, oven: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    text = (
        f"{HEAD}\nclass Oven(OvenBase):\n    CLASS_LEVEL = 1\n\n"
        f"    def on_execute(self, ec_id: int) -> ReturnCode_t:\n        {statement}\n"
        "        return RTC_OK\n\n    def made_below(self) -> None: ...\n"
    )
    assert _uses(oven, text, capfd) == IN_A_METHOD[statement]


ANSWERS = {
    # the body of on_execute: the line of the finding, from its head on
    "pass": 0,
    "self.count = 1": 0,
    "return": 1,
    "return None": 1,
    "if self.count:\n    return RTC_OK": 0,
    "if self.count:\n    return\nreturn RTC_OK": 2,
    "for x in ():\n    return RTC_OK": 0,
    "while self.count:\n    return RTC_OK": 0,
    "while True:\n    break": 0,
    "try:\n    return RTC_OK\nexcept OSError:\n    pass": 0,
    "try:\n    pass\nexcept OSError:\n    return RTC_OK": 0,
    "match self.count:\n    case 1:\n        return RTC_OK": 0,
    "with self.lock:\n    self.count = 1": 0,
    "super().on_execute(ec_id)": 0,
    "def inner():\n    return RTC_OK": 0,
    "return RTC_OK": None,
    "...": None,
    "raise NotImplementedError": None,
    "return self.fail('x')": None,
    "return super().on_execute(ec_id)": None,
    "if self.count:\n    return RTC_OK\nelse:\n    raise OSError": None,
    "if ec_id:\n    return RTC_OK\nelif self.x:\n    return 0\nelse:\n    return 0": None,
    "while True:\n    self.count = 1": None,
    "while True:\n    for x in ():\n        break": None,
    "for x in ():\n    pass\nelse:\n    return RTC_OK": None,
    "try:\n    return RTC_OK\nexcept OSError:\n    return RTC_ERROR": None,
    "try:\n    self.x = 1\nexcept OSError:\n    return 1\nelse:\n    return RTC_OK": None,
    "try:\n    self.count = 1\nfinally:\n    return RTC_OK": None,
    "match self.x:\n    case 1:\n        return RTC_OK\n    case _:\n        raise OSError": None,
    "with self.lock:\n    return RTC_OK": None,
    "def inner():\n    return\nreturn RTC_OK": None,
    "sys.exit(1)": None,
}


@pytest.mark.parametrize("body", ANSWERS)
def test_callbacks_without_a_return_code(body: str) -> None:
    text = "from myrobot.components.oven import OvenBase\n\nclass Oven(OvenBase):\n"
    for name in ("on_execute", "helper"):
        text += f"    def {name}(self, ec_id):\n" + indent(body, " " * 8) + "\n\n"
    found = [*behaviour_callbacks.findings("myrobot", "oven.py", text)]
    lines = [d.span.line - 4 for d in found if d.span is not None]
    assert {d.code for d in found} <= {"PRJ0026"}
    assert lines == [each for each in (ANSWERS[body],) if each is not None]


MODULES = {
    "from myrobot.kitchen import Heta": ["Heta"],
    "from myrobot.kitchens import Heat": ["myrobot.kitchens"],
    "from myrobot import kitchens": ["kitchens"],
    "from myrobot.components.oven import OvenBase, OvenBasis": ["OvenBasis"],
    "from myrobot.components import oven": [],
    "import myrobot.kitchen": [],
    "from myrobots.kitchen import Heta": [],
    "from myrobot.kitchen import *": [],
    f"{HEAD}class Oven(OvenBase):\n    def m(me): return me.gone": ["gone"],
    f"{HEAD}class Oven(OvenBase):\n    @staticmethod\n    def m(me): return me.gone": [],
    f"{HEAD}class Oven(OvenBase):\n    @classmethod\n    def m(me): return me.gone": [],
    f"{HEAD}class Oven(OvenBase):\n    def __getattr__(self, n): return self.gone": [],
    f"{HEAD}class Helper:\n    def m(self): return self.gone": [],
    f"{HEAD}from elsewhere import Mixed\nclass Oven(Mixed, OvenBase):\n"
    "    def m(self): return self.gone, self.config.gone": [],
    f"{HEAD}class Mixed:\n    def own(self): self.kept = 1\nclass Oven(Mixed, OvenBase):\n"
    "    def m(self): return self.kept, self.own, self.gone": ["gone"],
    f"{HEAD}class Oven(OvenBase):\n    async def m(self): return self.gone": ["gone"],
    f"{HEAD}class First(OvenBase): ...\nclass Oven(First):\n"
    "    def m(self): return self.gone": ["gone"],
    f"{HEAD}class Oven(OvenBase):\n    gone: int\n    def m(self): return self.gone": [],
    "import myrobot.components.oven as o\nclass Oven(o.OvenBase):\n"
    "    def m(self): return self.gone": ["gone"],
}


@pytest.mark.sampled(6)
@pytest.mark.parametrize("module", MODULES)
def test_uses_in_modules(
    module: str, oven: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    assert _uses(oven, f"{module}\n", capfd) == MODULES[module]


def test_classes_of_the_users_own_modules_are_followed(
    oven: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    Path("src/shared.py").write_text(
        "class Shared:\n    def helper(self) -> None:\n        self.kept = 1\n"
    )
    text = (
        f"{HEAD}from shared import Shared\n\n\nclass Oven(Shared, OvenBase):\n"
        "    def m(self): return self.kept, self.helper(), self.gone\n"
    )
    assert _uses(oven, text, capfd) == ["gone"]
