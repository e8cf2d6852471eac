"""Plug-ins of an installed package in each group of entry points, with options."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from rtgen import api
from rtgen.cli import run
from rtgen.compiler.diagnostics import explain
from rtgen.compiler.project import kinds

MODULE = '''
from contextlib import contextmanager
from msgspec.structs import replace
from pathlib import Path

from rtgen.compiler.backends import Artifact, Emission
from rtgen.compiler.diagnostics import Rule, Severity, Span
from rtgen.compiler.frontends import Dependency, FrontendResult
from rtgen.compiler.lowering.stage import Lowered
from rtgen.compiler.model import Model, SourceFile, Struct

SHORT = Rule("ACME0001", "A name is short", Severity.WARNING, "Names say what they are.")
EMPTY = Rule("ACME0002", "A list is empty", Severity.ERROR, "Write a name on each line.")
TWIN = Rule("ACME0003", "A name is taken by a twin", Severity.ERROR, "Choose another suffix.")
RULES = (SHORT, EMPTY, TWIN)


class Lists:
    """One struct for each line of a file."""

    suffixes = (".list",)

    def load(self, paths, *, root, include, options):
        files, structs, found, sources = [], [], [], {}
        for path in paths:
            shown, text = path.as_posix(), path.read_text()
            sources[shown] = text
            files.append(SourceFile(name=shown, key=path.name, sha256="0" * 64, main=True))
            if not text:
                found.append(EMPTY.at(Span(shown, 1, 1, 1, 2), "no names"))
            for number, name in enumerate(text.split(), start=1):
                span = Span(shown, number, 1, number, 1 + len(name))
                name = options.get("prefix", "") + name
                structs.append(Struct(
                    span=span, name=(name,), repository_id=f"IDL:{name}:1.0", file=shown, members=()
                ))
        model = Model(files=tuple(files), declarations=tuple(structs))
        read = tuple(Dependency(path, None) for path in paths)
        return FrontendResult(model, tuple(found), sources, read)


def check(context):
    least = context.options.get("acme", {}).get("least", 3)
    for declaration in context.declarations:
        if len(declaration.name[-1]) < least:
            yield SHORT.at(declaration.span, f"{declaration.name[-1]} is short")


class Names:
    name = "acme-names"

    def emit(self, model, options):
        mark = options.plugins.get("acme", {}).get("mark", "-")
        lines = [f"{mark} {d.scoped}\\n" for d in model.declarations if isinstance(d, Struct)]
        return Emission([Artifact("names.txt", "".join(lines), tuple(f.key for f in model.files))])


def lower(model, settings):
    """A twin of each struct; one that has a twin already is an error."""
    options = settings.plugins.get("acme", {})
    if "twins" not in options:
        return Lowered(model)
    known = {d.name for d in model.declarations}
    twins, found = [], []
    for struct in model.declarations:
        name = (struct.name[-1] + options["twins"],)
        if name in known:
            found.append(TWIN.at(struct.span, f"{struct.scoped} has a twin already"))
        twins.append(replace(struct, name=name, repository_id=f"IDL:{name[0]}:1.0"))
    whole = replace(model, declarations=(*model.declarations, *twins))
    return Lowered(whole, tuple(found))


@contextmanager
def opened(options, *, simulated):
    print(f"opened {options} {simulated}")
    yield Transport()


class Transport:
    def serve(self, component):
        print(f"serves {component.instance_name}")

    def withdraw(self, component):
        print(f"withdraws {component.instance_name}")

    def reach(self, consumer_interface, provider):
        return provider

    def await_others(self, seconds):
        print("awaits others")

    def is_ready(self, instance, before):
        return True
'''
ENTRY_POINTS = """
[rtgen.frontends]
acme = acme_rtgen:Lists
[rtgen.lint]
acme = acme_rtgen:check
[rtgen.rules]
acme = acme_rtgen:RULES
[rtgen.lowerings]
acme = acme_rtgen:lower
[rtgen.backends]
acme = acme_rtgen:Names
[rtgen.transports]
acme = acme_rtgen:opened
"""


@pytest.fixture(autouse=True)
def installed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Install a package with plug-ins virtually; the working folder is an empty project."""
    site = tmp_path / "site"
    (site / "acme-1.0.dist-info").mkdir(parents=True)
    (site / "acme_rtgen.py").write_text(MODULE.replace("Lists:", "_Lists:", 1))
    text = (site / "acme_rtgen.py").read_text()
    text += "\n\nLists = _Lists()\nNames = Names()\n"
    (site / "acme_rtgen.py").write_text(text)
    info = {"METADATA": "Name: acme\nVersion: 1.0\n", "entry_points.txt": ENTRY_POINTS}
    for name, content in info.items():
        (site / "acme-1.0.dist-info" / name).write_text(content)
    monkeypatch.syspath_prepend(site)
    monkeypatch.setenv("RTGEN_CACHE_DIR", str(tmp_path / "cache"))
    (tmp_path / "project" / "defs").mkdir(parents=True)
    monkeypatch.chdir(tmp_path / "project")
    Path("rtgen.toml").write_text('[sources]\npaths = ["defs"]\n')
    Path("defs/a.list").write_text("Pose\nXy\n")
    _forget()
    yield
    sys.modules.pop("acme_rtgen", None)
    _forget()


def _forget() -> None:
    explain.rules.cache_clear()
    kinds.plugin_suffixes.cache_clear()


def settings(text: str) -> None:
    Path("rtgen.toml").write_text(f'[sources]\npaths = ["defs"]\n{text}')


def test_a_front_end_reads_its_files(capfd: pytest.CaptureFixture[str]) -> None:
    settings('[plugin.acme]\nprefix = "My"\n')
    assert run(["inspect", "--json"]) == 0
    declared = json.loads(capfd.readouterr().out)["declarations"]
    assert [d["name"] for d in declared] == ["MyPose", "MyXy"]
    Path("defs/b.list").write_text("")
    assert run(["inspect"]) == 2
    assert "error[ACME0002]: no names" in capfd.readouterr().err


def test_files_of_one_kind_can_be_named(capfd: pytest.CaptureFixture[str]) -> None:
    assert run(["inspect", "defs/a.list", "--json"]) == 0
    assert "Pose" in capfd.readouterr().out


def test_a_lint_check_has_options(capfd: pytest.CaptureFixture[str]) -> None:
    assert run(["lint"]) == 1
    assert "warning[ACME0001]: Xy is short" in capfd.readouterr().err
    assert run(["lint", "--ignore", "ACME0001"]) in (0, 1)
    assert "ACME0001" not in capfd.readouterr().err
    settings("[plugin.acme]\nleast = 2\n")
    run(["lint"])
    assert "ACME0001" not in capfd.readouterr().err


def test_rules_are_explained(capfd: pytest.CaptureFixture[str]) -> None:
    assert run(["explain", "acme0001"]) == 0
    output = capfd.readouterr().out
    assert output == "# ACME0001: A name is short\n\nNames say what they are.\n"


def test_a_code_that_is_taken_is_refused(capfd: pytest.CaptureFixture[str]) -> None:
    file = next(
        Path(p) for p in sys.path if "site" in p and Path(p, "acme_rtgen.py").exists()
    )
    text = (file / "acme_rtgen.py").read_text()
    (file / "acme_rtgen.py").write_text(text.replace("ACME0001", "IDL0200"))
    sys.modules.pop("acme_rtgen", None)
    assert run(["explain", "IDL0200"]) == 3
    assert "have the code IDL0200, which is taken" in capfd.readouterr().err


def test_a_back_end_has_options_and_the_cache_knows_them() -> None:
    for mark in ("-", "*"):
        settings(f'[plugin.acme]\nmark = "{mark}"\n')
        assert run(["generate", "-q"]) == 0
        assert Path("generated/names.txt").read_text() == f"{mark} Pose\n{mark} Xy\n"
        assert run(["check", "-q"]) == 0


def test_a_lowering_adds_to_what_back_ends_take(
    capfd: pytest.CaptureFixture[str],
) -> None:
    settings('[plugin.acme]\ntwins = "Twin"\n')
    assert run(["generate", "-q"]) == 0
    names = Path("generated/names.txt").read_text()
    assert names == "- Pose\n- Xy\n- PoseTwin\n- XyTwin\n"
    assert "class PoseTwin" in Path("generated/robots/_idl/a.py").read_text()
    assert run(["inspect", "--json"]) == 0
    declared = json.loads(capfd.readouterr().out)["declarations"]
    assert [d["name"] for d in declared] == ["Pose", "Xy"]
    result = api.read([Path("defs/a.list")], lowered=True)
    assert [d.scoped for d in result.model.declarations][-1] == "XyTwin"


def test_an_error_of_a_lowering_ends_the_run(
    capfd: pytest.CaptureFixture[str],
) -> None:
    Path("defs/a.list").write_text("Pose\nPoseTwin\n")
    settings('[plugin.acme]\ntwins = "Twin"\n')
    assert run(["generate"]) == 2
    error = capfd.readouterr().err
    assert "error[ACME0003]: Pose has a twin already" in error
    assert "defs/a.list:1:1" in error
    assert not Path("generated").exists()
    assert run(["explain", "ACME0003"]) == 0
    assert "Choose another suffix." in capfd.readouterr().out


def test_options_are_tables(capfd: pytest.CaptureFixture[str]) -> None:
    settings("[plugin]\nacme = 1\n")
    assert run(["generate"]) == 2
    assert "must be a table" in capfd.readouterr().err


SYSTEM = """<rts:RtsProfile rts:id="RTSystem:v:s:1"
 xmlns:rts="http://www.openrtp.org/namespaces/rts">
<rts:Components rts:id="RTC:v:c:Quiet:1.0.0" rts:instanceName="Quiet0"/>
</rts:RtsProfile>"""
QUIET = """from rtgen.runtime import Component, ComponentProfile
class Quiet(Component):
    profile = ComponentProfile("Quiet", "c", "v", "1.0.0")
"""


def test_a_transport_carries_a_run(capfd: pytest.CaptureFixture[str]) -> None:
    Path("src").mkdir()
    Path("src/quiet_component.py").write_text(QUIET)
    Path("s.xml").write_text(SYSTEM)
    settings('[components]\nQuiet = "quiet_component:Quiet"\n[plugin.acme]\nport = 7\n')
    assert run(["run", "s.xml", "--until", "1", "--transport", "acme", "-q"]) == 0
    output = capfd.readouterr().out
    assert output.startswith("opened {'port': 7} True\nserves Quiet0\nawaits others\n")
    assert "withdraws Quiet0" in output
    assert run(["run", "s.xml", "--until", "1", "--transport", "acne"]) == 2
    assert "'acne' is not one of 'direct', 'corba'" in capfd.readouterr().err


def test_options_of_a_plugin_that_is_not_there(
    capfd: pytest.CaptureFixture[str],
) -> None:
    settings('[plugin.acne]\nprefix = "My"\n')
    assert run(["check", "--only", "lint"]) == 2
    err = capfd.readouterr().err
    assert "rtgen.toml:3:2: error[PRJ0002]: no plug-in 'acne' is installed" in err
    assert "hint: did you mean 'acme'?" in err
    settings("[plugin.other]\nx = 1\n[plugin.acme]\nleast = 2\n")
    run(["inspect"])
    err = capfd.readouterr().err
    assert "rtgen.toml:3:2: warning[PRJ0021]: no plug-in 'other' is installed" in err
    assert "acme" not in err.replace("known: ", "")[: err.index("hint")]
