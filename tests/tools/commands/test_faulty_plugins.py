"""Plug-ins that fail, give other things than they should, or give no end of them."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from rtgen.cli import run
from rtgen.compiler.diagnostics import explain
from rtgen.compiler.project import kinds

HEAD = """
from itertools import repeat
from pathlib import Path
from types import SimpleNamespace
from contextlib import contextmanager

from rtgen.compiler.backends import Artifact, Emission
from rtgen.compiler.diagnostics import InputError, Rule, Severity, Span, ToolError
from rtgen.compiler.frontends import Dependency, FrontendResult
from rtgen.compiler.lowering.stage import Lowered
from rtgen.compiler.model import Model

RULE = Rule("ACME0001", "A name is short", Severity.WARNING, "Names say what they are.")


def raises(*_, **__):
    raise RuntimeError("first line\\nsecond line")


def exits(*_, **__):
    raise SystemExit(0)


def gives(value):
    return lambda *_, **__: value


def backend(emit, name="acme"):
    return SimpleNamespace(name=name, emit=emit)


def frontend(load, suffixes=(".list",)):
    return SimpleNamespace(suffixes=suffixes, load=load)


"""
GROUPS = {
    "backends": ("generate", "--no-cache"),
    "frontends": ("inspect",),
    "lint": ("lint",),
    "lowerings": ("generate", "--no-cache"),
    "rules": ("explain", "IDL0101"),
    "transports": ("run", "s.xml", "--until", "0.1", "--transport", "acme"),
}
"""The groups of entry points, each with a command that uses it."""

AT_IMPORT = (
    *("raise RuntimeError('no')", "raise SystemExit(0)", "import not_there", "1 / 0"),
    *("def", "X = None", "from rtgen import not_there"),
)

WRONG: dict[str, tuple[str, ...]] = {
    "backends": (
        *("5", "None", "SimpleNamespace()", "backend(raises)", "backend(exits)"),
        *("backend(gives(None))", "backend(gives([]))", "backend(5)"),
        "backend(gives(Emission()), name=5)",
        "backend(gives(Emission(None)))",
        "backend(gives(Emission([5])))",
        "backend(gives(Emission(repeat(Artifact('a', 'b', ())))))",
        "backend(gives(Emission([Artifact(5, 'b', ())])))",
        "backend(gives(Emission([Artifact(Path('a'), 'b', ())])))",
        "backend(gives(Emission([Artifact('a', b'b', ())])))",
        "backend(gives(Emission([Artifact('a', 'b', (5,))])))",
        "backend(gives(Emission([Artifact('a', 'b', (), 'me')])))",
        "backend(gives(Emission((), ['text'])))",
        "backend(gives(Emission((), (), {})))",
    ),
    "frontends": (
        *("5", "None", "SimpleNamespace()", "frontend(raises)", "frontend(exits)"),
        *("frontend(gives(None))", "frontend(gives(Model()))", "frontend(5)"),
        *(
            "frontend(gives(None), '.list')",
            "frontend(gives(None), (5,))",
            "frontend(gives(None), ('list',))",
            "frontend(gives(None), ('',))",
            "frontend(gives(None), repeat('.list'))",
        ),
        "frontend(gives(FrontendResult(None, (), {}, ())))",
        "frontend(gives(FrontendResult(Model(), (5,), {}, ())))",
        "frontend(gives(FrontendResult(Model(), (), 5, ())))",
        "frontend(gives(FrontendResult(Model(), (), {}, ('a',))))",
        "frontend(gives(FrontendResult(Model(), (), {}, (), ('a',))))",
    ),
    "lint": (
        *("5", "None", "raises", "exits", "gives(None)", "gives(5)", "gives(['text'])"),
        "gives(repeat(RULE.at(None, 'again')))",
    ),
    "lowerings": (
        *("5", "None", "raises", "exits", "gives(None)", "gives(Model())"),
        *("gives(Lowered(None))", "lambda model, _: Lowered(model, [5])"),
    ),
    "rules": ("5", "None", "(5,)", "repeat(RULE)", "(Severity.WARNING,)"),
    "transports": (
        *("5", "None", "raises", "exits", "gives(None)", "gives(5)"),
        "contextmanager(lambda *_, **__: iter(()))",
        "contextmanager(raises)",
    ),
}
"""Objects of entry points, as Python, for each group."""

SYSTEM = """<rts:RtsProfile rts:id="RTSystem:v:s:1"
 xmlns:rts="http://www.openrtp.org/namespaces/rts">
<rts:Components rts:id="RTC:v:c:Quiet:1.0.0" rts:instanceName="Quiet0"/>
</rts:RtsProfile>"""
QUIET = """from rtgen.runtime import Component, ComponentProfile
class Quiet(Component):
    profile = ComponentProfile("Quiet", "c", "v", "1.0.0")
"""

Install = Callable[..., None]


def forget() -> None:
    sys.modules.pop("acme_rtgen", None)
    explain.rules.cache_clear()
    kinds.plugin_suffixes.cache_clear()


@pytest.fixture
def install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Install]:
    """Return a function that installs a plug-in virtually; the working folder is a project."""
    (tmp_path / "project" / "defs").mkdir(parents=True)
    monkeypatch.chdir(tmp_path / "project")
    monkeypatch.setenv("RTGEN_CACHE_DIR", str(tmp_path / "cache"))
    monkeypatch.delenv("RTGEN_DEBUG", raising=False)
    Path("rtgen.toml").write_text(
        '[sources]\npaths = ["defs"]\n[components]\nQuiet = "quiet:Quiet"\n'
    )
    Path("defs/a.idl").write_text("module M { struct S { long a; }; };\n")
    Path("defs/a.list").write_text("")
    Path("s.xml").write_text(SYSTEM)
    Path("src").mkdir()
    Path("src/quiet.py").write_text(QUIET)

    def install(module: str, entry_points: str) -> None:
        site = tmp_path / "site"
        info = site / "acme-1.0.dist-info"
        info.mkdir(parents=True)
        (site / "acme_rtgen.py").write_text(module)
        (info / "METADATA").write_text("Name: acme\nVersion: 1.0\n")
        (info / "entry_points.txt").write_text(entry_points)
        monkeypatch.syspath_prepend(site)
        forget()

    forget()
    yield install
    forget()


def check_refusal(
    command: tuple[str, ...], capfd: pytest.CaptureFixture[str], words: str
) -> str:
    """Check that a command ends with one error of the environment, and without files."""
    files = {*Path().rglob("*")}
    assert run([*command]) == 3
    errors = capfd.readouterr().err
    lines = [line for line in errors.splitlines() if "error" in line]
    assert lines[0].startswith(f"error[ENV0001]: {words}"), errors
    assert lines[1:] == ["1 error"], errors
    assert "Traceback" not in errors
    assert {*Path().rglob("*")} - files <= {Path("src/__pycache__")}
    return errors


@pytest.mark.sampled(10)
@pytest.mark.parametrize("group", GROUPS)
@pytest.mark.parametrize("line", AT_IMPORT)
def test_an_import_that_fails_is_named(
    install: Install, capfd: pytest.CaptureFixture[str], group: str, line: str
) -> None:
    install(f"{line}\n", f"[rtgen.{group}]\nacme = acme_rtgen:Y\n")
    named = f"the plug-in 'acme' of rtgen.{group} (acme_rtgen:Y) cannot be loaded: "
    check_refusal(GROUPS[group], capfd, named)


@pytest.mark.sampled(16)
@pytest.mark.parametrize(
    ("group", "value"), [(group, each) for group in WRONG for each in WRONG[group]]
)
def test_what_a_plug_in_gives_is_checked(
    install: Install, capfd: pytest.CaptureFixture[str], group: str, value: str
) -> None:
    install(f"{HEAD}Y = {value}\n", f"[rtgen.{group}]\nacme = acme_rtgen:Y\n")
    named = f"the plug-in 'acme' of rtgen.{group} failed: "
    errors = check_refusal(GROUPS[group], capfd, named)
    if "raises" in value:
        assert "RuntimeError: first line second line\n" in errors


@pytest.mark.parametrize(
    "path",
    ["../a", "/tmp/a", "a/../../b", "a/./b", "", ".rtgen.json", "a\\b", "a\0b", "C:a"],
)
def test_files_of_a_plug_in_are_in_the_output_folder(
    install: Install, capfd: pytest.CaptureFixture[str], path: str
) -> None:
    module = f"{HEAD}Y = backend(gives(Emission([Artifact({path!r}, 'text', ())])))\n"
    install(module, "[rtgen.backends]\nacme = acme_rtgen:Y\n")
    files = {*Path().parent.rglob("*")}
    assert run(["generate", "--no-cache"]) == 2
    assert "error[PRJ0102]" in capfd.readouterr().err
    assert {*Path().parent.rglob("*")} == files


@pytest.mark.parametrize("path", ["robots/__init__.py", "Robots/__INIT__.py", "twice"])
def test_files_of_one_name_are_refused(
    install: Install, capfd: pytest.CaptureFixture[str], path: str
) -> None:
    module = f"{HEAD}Y = backend(gives(Emission([Artifact({path!r}, 'text', ())])))\n"
    install(
        module + "Z = Y\n", "[rtgen.backends]\na = acme_rtgen:Y\nb = acme_rtgen:Z\n"
    )
    assert run(["generate", "--no-cache"]) == 2
    assert "error[PRJ0101]" in capfd.readouterr().err
    assert not Path("generated").exists()


def test_a_finding_of_a_plug_in_is_no_failure(
    install: Install, capfd: pytest.CaptureFixture[str]
) -> None:
    module = f"{HEAD}def Y(*_):\n    raise InputError([RULE.at(None, 'too short')])\n"
    install(module, "[rtgen.lint]\nacme = acme_rtgen:Y\n")
    assert run(["lint"]) == 2
    assert "warning[ACME0001]: too short" in capfd.readouterr().err


@pytest.mark.parametrize("line", ["acme", "= x", "acme = ", "acme = a b c", "[", "\0"])
def test_malformed_entry_points(
    install: Install, capfd: pytest.CaptureFixture[str], line: str
) -> None:
    install("", f"[rtgen.backends]\n{line}\n")
    assert run(["generate", "--no-cache"]) in (0, 3)
    errors = capfd.readouterr().err
    assert "internal error" not in errors
    assert "Traceback" not in errors


TRANSPORT = """
class Transport:
    def serve(self, component):
        {serve}

    def withdraw(self, component):
        {withdraw}

    def reach(self, consumer_interface, provider):
        return provider

    def await_others(self, seconds):
        {await_others}

    def is_ready(self, instance, before):
        {is_ready}


@contextmanager
def Y(*_, **__):
    yield Transport()
    {end}
"""


@pytest.mark.parametrize("method", ["serve", "await_others", "end"])
def test_a_transport_that_fails_during_a_run_is_named(
    install: Install, capfd: pytest.CaptureFixture[str], method: str
) -> None:
    lines = dict.fromkeys(("serve", "withdraw", "await_others", "end"), "pass")
    lines["is_ready"] = "return True"
    module = HEAD + TRANSPORT.format_map({**lines, method: "raises()"})
    install(module, "[rtgen.transports]\nacme = acme_rtgen:Y\n")
    assert run([*GROUPS["transports"]]) == 3
    errors = capfd.readouterr().err
    named = "the plug-in 'acme' of rtgen.transports failed: RuntimeError: first line"
    assert f"error[ENV0001]: {named} second line\n" in errors
    assert "internal error" not in errors
