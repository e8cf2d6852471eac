"""`rtgen check`: everything that can be checked without a run, each at its place."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from msgspec.structs import replace

from rtgen.cli import run
from rtgen.compiler.project import load
from rtgen.compiler.project.output import MANIFEST, Change, plan
from rtgen.tools.compiling.cached import build

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
