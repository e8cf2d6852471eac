"""Timelines beside systems: `rtgen check` and `rtgen lint` fail where `rtgen run` skips events."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from rtgen.cli import run

IDL = """\
struct Sample { long value; };
component Source { publishes Sample made; };
enum Power { OFF, ON };
component Sink {
    consumes Sample taken;
    @default(1.0) @min(0.5) @max(3.0) @unit("m") attribute double limit;
    @default(ON) attribute Power mode;
    attribute long count;
};
"""
PROJECT = '[sources]\npaths = ["idl", "systems"]\n[lint]\nignore = ["LINT0008"]\n'
SYSTEM = """\
<?xml version="1.0" encoding="UTF-8"?>
<rts:RtsProfile rts:id="RTSystem:t:S:0" rts:version="0.2"
    xmlns:rts="http://www.openrtp.org/namespaces/rts"
    xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance">
{components}{connection}</rts:RtsProfile>
"""
COMPONENT = """\
  <rts:Components rts:instanceName="{name}" rts:id="RTC:::{type}:1.0.0" rts:pathUri=""
    rts:isRequired="true"/>
"""
CONNECTION = """\
  <rts:DataPortConnectors rts:name="wire" rts:connectorId="7f" rts:interfaceType="direct"
    rts:dataType="Sample" rts:dataflowType="push" rts:subscriptionType="flush">
    <rts:sourceDataPort rts:componentId="RTC:::Source:1.0.0" rts:instanceName="A"
      rts:portName="made"/>
    <rts:targetDataPort rts:componentId="RTC:::Sink:1.0.0" rts:instanceName="B"
      rts:portName="taken"/>
  </rts:DataPortConnectors>
"""
SETS = """
    <rts:ConfigurationSets rts:id="default">
      <rts:ConfigurationData rts:name="{name}" rts:data="{value}"/>
    </rts:ConfigurationSets>
"""
NEW = '{ from = "A.made", to = "B.taken", name = "new" }'


def at(*events: str) -> str:
    """Return a timeline with an event each second."""
    return "".join(f"[[at]]\nt = {n}\n{each}\n" for n, each in enumerate(events, 1))


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    Path("idl").mkdir()
    Path("idl/a.idl").write_text(IDL)
    Path("rtgen.toml").write_text(PROJECT)
    Path("systems").mkdir()
    names = ("A", "Source"), ("B", "Sink")
    components = "".join(COMPONENT.format(name=n, type=t) for n, t in names)
    text = SYSTEM.format(components=components, connection=CONNECTION)
    Path("systems/system.xml").write_text(text)
    assert run(["generate", "-q"]) == 0
    return tmp_path


def lines(text: str) -> list[int]:
    """Return the lines of a timeline at which events are reported as skipped."""
    assert "error" not in text
    places = re.findall(r"systems/timeline.toml:(\d+):1: warning\[SYS0027\]", text)
    return [int(each) for each in places]


@pytest.mark.sampled(4)
@pytest.mark.parametrize(
    ("events", "skipped"),
    [
        ([], []),
        (['disconnect = "wire"', 'connect = "wire"', 'disconnect = "7f"'], []),
        ([f"connect = {NEW}", 'disconnect = "new"', f"connect = {NEW}"], []),
        (['deactivate = "A"', 'activate = "A"'], []),
        (['disconnect = { from = "A.made", to = "B.taken" }'], []),
        (['disconnect = "wier"'], [3]),
        (['disconnect = "wire"', 'deactivate = "C"'], [6]),
        (['activate = ["A", "C", "D"]'], [3, 3]),
        (['set = "C.x=1"'], [3]),
        (['connect = { from = "A.made", to = "C.taken" }'], [3]),
        (['disconnect = { from = "A.made", to = "C.taken" }'], [3]),
        # The connection is made later, was cut before, or exists.
        (['disconnect = "new"', f"connect = {NEW}"], [3]),
        (['disconnect = "wire"', 'disconnect = "wire"'], [6]),
        (['connect = "wire"'], [3]),
        ([f"connect = {NEW}", 'disconnect = "new"', 'disconnect = "new"'], [9]),
    ],
)
def test_events_that_every_run_skips(
    folder: Path,
    events: list[str],
    skipped: list[int],
    capsys: pytest.CaptureFixture[str],
) -> None:
    Path("systems/timeline.toml").write_text(at(*events))
    for command in ("check", "lint"):
        assert run([command]) == bool(skipped)
        assert lines(capsys.readouterr().err) == skipped


def test_a_timeline_with_an_error_is_an_error(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    Path("systems/timeline.toml").write_text('[[at]]\nt = 1\nfly = "A"\n')
    for command in ("check", "lint"):
        assert run([command]) == 2
        assert "unknown key 'fly'" in capsys.readouterr().err


def test_a_timeline_that_follows_another(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    Path("systems/first.toml").write_text(at(f"connect = {NEW}"))
    second = '[[at]]\nt = 2\ndisconnect = "new"\n[[at]]\nt = 3\ndisconnect = "old"\n'
    Path("systems/timeline.toml").write_text('follows = "first.toml"\n' + second)
    assert run(["check"]) == 1
    assert lines(capsys.readouterr().err) == [7]


def test_other_files_have_no_timeline(folder: Path) -> None:
    Path("systems/system.xml").rename("systems/other.xml")
    Path("systems/timeline.toml").write_text(at('activate = "C"'))
    assert run(["check", "-q"]) == 0


@pytest.mark.sampled(6)
@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("B.limit=3", None),
        ("B.mode=OFF", None),
        ("B.mode=Power::OFF", None),
        ("B.count=-7", None),
        ("B.limit=3.1", "B.limit cannot be '3.1': it must be at most 3.0 m"),
        ("B.limit=0", "B.limit cannot be '0': it must be at least 0.5 m"),
        ("B.limit=much", "B.limit cannot be 'much': it must be a number"),
        ("B.mode=AUTO", "B.mode cannot be 'AUTO': it must be one of OFF, ON"),
        ("B.count=2147483648", "it must be between -2147483648 and 2147483647"),
        ("B.limmit=1", "Sink has no parameter 'limmit'"),
        ("A.limit=1", "Source has no parameter 'limit'"),
    ],
)
@pytest.mark.parametrize("place", ["timeline", "system"])
def test_values_of_parameters(
    folder: Path,
    text: str,
    problem: str | None,
    place: str,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """The check says what a run says."""
    if place == "timeline":
        Path("systems/timeline.toml").write_text(at(f'set = "{text}"'))
    else:
        instance, _, assignment = text.partition(".")
        name, _, value = assignment.partition("=")
        file = Path("systems/system.xml")
        sets = SETS.format(name=name, value=value)
        head = f'rts:instanceName="{instance}"'
        start = file.read_text().index("/>", file.read_text().index(head))
        whole = file.read_text()
        file.write_text(f"{whole[:start]}>{sets}</rts:Components>{whole[start + 2:]}")
    assert run(["check"]) == (2 if problem else 0)
    err = capsys.readouterr().err
    assert (problem or "") in err
    assert ("error" in err) is bool(problem)
