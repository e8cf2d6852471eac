"""The listings of docs/extending.md form a package that works as described."""

from __future__ import annotations

import re
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest

from rtgen.cli import run
from rtgen.compiler.diagnostics import explain
from rtgen.compiler.project import kinds

PAGE = Path(__file__).parents[3] / "docs" / "extending.md"
LISTING = re.compile(r"<!-- page: file (\S+) -->\n```\w+\n(.*?)```", re.DOTALL)
SHOWN = re.compile(
    r"^\$ (rtgen [^\n]*|cat [^\n]*)\n((?:[^$`\n][^\n]*\n)*)", re.MULTILINE
)

SYSTEM = """<rts:RtsProfile rts:id="RTSystem:v:s:1"
 xmlns:rts="http://www.openrtp.org/namespaces/rts">
<rts:Components rts:id="RTC:v:c:Quiet:1.0.0" rts:instanceName="Quiet0"/>
</rts:RtsProfile>"""
QUIET = """from rtgen.runtime import Component, ComponentProfile
class Quiet(Component):
    profile = ComponentProfile("Quiet", "c", "v", "1.0.0")
"""


@pytest.fixture(autouse=True)
def package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Install the package of the page virtually, with its project as the working folder."""
    text = PAGE.read_text(encoding="utf-8")
    for name, content in LISTING.findall(text):
        file = tmp_path / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(content, encoding="utf-8")
    (tmp_path / "acme" / "acme_rtgen" / "__init__.py").touch()
    project = tomllib.loads((tmp_path / "acme" / "pyproject.toml").read_text())[
        "project"
    ]
    info = tmp_path / "acme" / "acme_rtgen-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text(
        f"Name: {project['name']}\nVersion: {project['version']}\n"
    )
    entries = "".join(
        f"[{group}]\n"
        + "".join(f"{name} = {value}\n" for name, value in points.items())
        for group, points in project["entry-points"].items()
    )
    (info / "entry_points.txt").write_text(entries)
    monkeypatch.syspath_prepend(tmp_path / "acme")
    monkeypatch.setenv("RTGEN_CACHE_DIR", str(tmp_path / "cache"))
    monkeypatch.chdir(tmp_path / "project")
    _forget()
    yield
    for name in [name for name in sys.modules if name.startswith("acme_rtgen")]:
        del sys.modules[name]
    _forget()


def _forget() -> None:
    explain.rules.cache_clear()
    kinds.plugin_suffixes.cache_clear()


def test_the_commands_print_what_the_page_shows(
    capfd: pytest.CaptureFixture[str],
) -> None:
    shown = SHOWN.findall(PAGE.read_text(encoding="utf-8"))
    assert [command.split()[0] for command, _ in shown] == ["rtgen", "cat", "rtgen"]
    for command, output in shown:
        program, *arguments = command.split()
        if program == "cat":
            assert Path(arguments[0]).read_text() == output
            continue
        run(arguments)
        out, err = capfd.readouterr()
        assert out + err == output


def test_the_rule_is_explained(capfd: pytest.CaptureFixture[str]) -> None:
    assert run(["explain", "ACME0001"]) == 0
    assert capfd.readouterr().out.startswith("# ACME0001: a name is short\n")


def test_the_transport_carries_a_run(capfd: pytest.CaptureFixture[str]) -> None:
    Path("src").mkdir()
    Path("src/quiet_component.py").write_text(QUIET)
    Path("s.xml").write_text(SYSTEM)
    with Path("rtgen.toml").open("a") as file:
        file.write('[components]\nQuiet = "quiet_component:Quiet"\n')
    command = [
        "run",
        "s.xml",
        "--transport",
        "acme",
        "--clock",
        "real",
        "--until",
        "0.1",
    ]
    assert run(command) == 0
    lines = capfd.readouterr().out.splitlines()
    assert [x for x in lines if x.startswith(("opens", "*", "closes"))] == [
        "opens",
        "* serves Quiet0",
        "* withdraws Quiet0",
        "closes",
    ]
