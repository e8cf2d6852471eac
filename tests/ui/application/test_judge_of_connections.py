"""Every asker has one verdict on a connection: the severity and the code of one judge."""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Final, NamedTuple

import pytest
from ui_bench import QUIET, Bench

from rtgen.cli import run
from rtgen.compiler.diagnostics import InputError
from rtgen.compiler.frontends.kit.memo import Memo
from rtgen.compiler.project import load
from rtgen.compiler.systems.connection_rules import CONNECTIONS
from rtgen.tools.lsp.analysis import analyse
from rtgen.tools.lsp.documents import Documents
from rtgen.ui.project_systems import CommandProject
from rtgen.ui.protocol import ui


class Pair(NamedTuple):
    """Two ends, as ports of IDL, and the verdict; `key` and `text` are a property of the connector.

    `verdict` is empty if there is no finding, or only notes.
    """

    name: str
    source: str
    target: str
    verdict: str
    key: str = ""
    text: str = ""


REASON = "checked on the bench"
PAIRS: Final = (
    Pair("same", '@unit("m/s") publishes D', '@unit("m / s") consumes D', ""),
    Pair(
        "dimension",
        '@unit("deg/s") publishes D',
        '@unit("N*m") consumes D',
        "error RTC0593",
    ),
    Pair(
        "scale",
        '@unit("mm") publishes D',
        '@unit("m") consumes D',
        "warning RTC0595",
    ),
    Pair(
        "angle",
        '@unit("1/min") publishes D',
        '@unit("rad/s") consumes D',
        "warning RTC0596",
    ),
    Pair("silent", '@unit("m") publishes D', "consumes D", ""),
    Pair(
        "member",
        "publishes Judged::Speed",
        '@unit("N*m") consumes Judged::Speed',
        "error RTC0593",
    ),
    Pair(
        "integer",
        "publishes Judged::Counts",
        '@unit("N*m") consumes Judged::Counts',
        "error RTC0593",
    ),
    Pair(
        "of_its_type",
        "publishes Judged::Speed",
        '@unit("rad/s") consumes Judged::Speed',
        "warning RTC0595",
    ),
    Pair("type", "publishes D", "consumes Judged::Speed", "error RTC0582"),
    Pair("direction", "consumes D", "consumes D", "error RTC0582"),
    Pair("interface", "provides Judged::Go", "uses Judged::Come", "error RTC0582"),
    Pair("derived", "provides Judged::Further", "uses Judged::Go", ""),
    Pair(
        "allowed",
        '@unit("deg/s") publishes D',
        '@unit("N*m") consumes D',
        "",
        "rtgen.allow.RTC0593",
        REASON,
    ),
    Pair(
        "allowed_scale",
        '@unit("mm") publishes D',
        '@unit("m") consumes D',
        "",
        "rtgen.allow.RTC0595",
        REASON,
    ),
    Pair(
        "in_vain",
        '@unit("m") publishes D',
        '@unit("m") consumes D',
        "warning RTC0597",
        "rtgen.allow.RTC0593",
        REASON,
    ),
)

BY_NAME: Final = {pair.name: pair for pair in PAIRS}
TYPES = """#include "BasicDataType.idl"
typedef RTC::TimedDouble D;
module Judged {
    struct Speed { double value; ///< Speed [deg/s].
    };
    struct Counts { long value; ///< Speed [deg/s].
    };
    interface Go { void start(); };
    interface Further : Go { void stop(); };
    interface Come { void call(); };
};
"""
SYSTEM = """<?xml version="1.0" encoding="UTF-8" standalone="yes"?>
<rts:RtsProfile rts:id="RTSystem:me:judged:1.0.0" rts:version="0.2"
    xmlns:rts="http://www.openrtp.org/namespaces/rts"
    xmlns:rtsExt="http://www.openrtp.org/namespaces/rts_ext">
  <rts:Components rts:id="RTC:me:Judged:{source}:1.0.0" rts:instanceName="{source}0"/>
  <rts:Components rts:id="RTC:me:Judged:{target}:1.0.0" rts:instanceName="{target}0"/>
{connector}</rts:RtsProfile>
"""
CONNECTOR = """  <rts:{kind}PortConnectors rts:name="wire">
    <rts:source{kind}Port rts:instanceName="{source}0" rts:portName="{source}0.one"/>
    <rts:target{kind}Port rts:instanceName="{target}0" rts:portName="{target}0.other"/>
{properties}  </rts:{kind}PortConnectors>
"""
PROPERTY = '    <rtsExt:Properties rtsExt:name="{}" rtsExt:value="{}"/>\n'
OUTPUT = '[output]\npackage = "judged_ends"\nskeletons = "src"\n'
CODES = {rule.code for rule in CONNECTIONS}

Asker = Callable[[Pair, "pytest.CaptureFixture[str]"], str]


def type_names(pair: Pair) -> dict[str, str]:
    stem = pair.name.title().replace("_", "")
    return {"source": f"{stem}Source", "target": f"{stem}Target"}


def component(name: str, port: str) -> str:
    return f'@rtc(category="Judged", vendor="me")\ncomponent {name} {{ {port}; }};\n'


def system(pair: Pair, *, connected: bool) -> str:
    names = type_names(pair)
    kind = "Service" if pair.source.startswith("provides") else "Data"
    properties = PROPERTY.format(pair.key, pair.text) if pair.key else ""
    connector = CONNECTOR.format(kind=kind, properties=properties, **names)
    return SYSTEM.format(connector=connector if connected else "", **names)


def timeline(pair: Pair) -> str:
    names = type_names(pair)
    allowed = f'properties = {{ "{pair.key}" = "{pair.text}" }}, ' if pair.key else ""
    ends = f'from = "{names["source"]}0.one", to = "{names["target"]}0.other"'
    return f"[[at]]\nt = 0.01\nconnect = {{ {allowed}{ends} }}\n"


@pytest.fixture(scope="module")
def project(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A project with the components of all pairs, generated; `own.mcap` is a recording."""
    folder = tmp_path_factory.mktemp("judged")
    text = TYPES
    for pair in PAIRS:
        names = type_names(pair)
        text += component(names["source"], f"{pair.source} one")
        text += component(names["target"], f"{pair.target} other")
    (folder / "ends.idl").write_text(text)
    (folder / "rtgen.toml").write_text(f'[sources]\npaths = ["ends.idl"]\n{OUTPUT}')
    (folder / "system.xml").write_text(system(BY_NAME["same"], connected=True))
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        assert run(["generate", "-q"]) == 0
        record = ["--until", "0.05", "-q", "--record", "own.mcap"]
        assert run(["run", "system.xml", *record]) == 0
    return folder


@pytest.fixture
def pair(
    request: pytest.FixtureRequest, project: Path, monkeypatch: pytest.MonkeyPatch
) -> Pair:
    """The pair of a test; its system is `wired/system.xml`, and `timed` has it as a timeline."""
    monkeypatch.chdir(project)
    given = BY_NAME[request.param]
    for folder, connected in (("wired", True), ("timed", False)):
        Path(folder).mkdir(exist_ok=True)
        file = Path(folder, "system.xml")
        file.write_text(system(given, connected=connected))
    Path("timed", "timeline.toml").write_text(timeline(given))
    return given


def verdict(found: Iterable[tuple[str, str]]) -> str:
    """Return the warnings and errors of the judge among severities with codes."""
    own = {f"{s} {code}" for s, code in found if code in CODES and s != "note"}
    return "; ".join(sorted(own))


def command(*words: str, file: str, source: bool = False) -> Asker:
    """Return the verdict of a command; with `source`, the system is one of the project's."""

    def ask(given: Pair, capfd: pytest.CaptureFixture[str]) -> str:
        more = f', "{file}"' if source else ""
        settings = f'[sources]\npaths = ["ends.idl"{more}]\n{OUTPUT}'
        Path("rtgen.toml").write_text(settings)
        capfd.readouterr()
        code = run([*words, "--diagnostics", "json"])
        said = json.loads(capfd.readouterr().err)
        wrong = any(d["severity"] == "error" for d in said)
        if words[0] != "ctl":
            assert (code == 2) is wrong, said
        return verdict((d["severity"], d["code"]) for d in said)

    return ask


def language_server(given: Pair, _: pytest.CaptureFixture[str]) -> str:
    settings = '[sources]\npaths = ["ends.idl", "wired/system.xml"]\n'
    Path("rtgen.toml").write_text(settings + OUTPUT)
    findings = analyse(load(), Documents().snapshot(), Memo()).findings
    return verdict((d.severity.value, d.code) for d in findings)


def opened_page(file: str) -> Asker:
    """Return the verdict of a page that opens a system."""

    def ask(_: Pair, capfd: pytest.CaptureFixture[str]) -> str:
        capfd.readouterr()
        try:
            CommandProject(QUIET, [file]).read(file)
        except InputError as error:
            return verdict((d.severity.value, d.code) for d in error.diagnostics)
        said = capfd.readouterr().err
        return verdict(re.findall(r"(error|warning)\[(\w+)\]", said))

    return ask


def page_that_connects(given: Pair, _: pytest.CaptureFixture[str]) -> str:
    """Return the verdict of a page on a connection that a person makes."""
    Path("timed", "timeline.toml").unlink()
    bench = Bench("timed/system.xml")
    try:
        page = bench.page()
        page.events()
        names = type_names(given)
        source = ui.PortAddress(f"{names['source']}0", "one")
        target = ui.PortAddress(f"{names['target']}0", "other")
        offers = page.done("ends", source).fits
        [offer] = [each for each in offers if each.port == target]
        stated = [ui.Value(given.key, given.text)] if given.key else []
        result = page.ask("wire", ui.Connect(source, target, "", stated))
        texts = [("error", result.message)]
        texts += (
            ("warning", each.reported.text)
            for each in page.seen
            if each.discriminator is ui.EventKind.EVENT_NOTICE
        )
        is_wrong = "error" in given.verdict
        assert result.done is not is_wrong
        if is_wrong:
            assert result.code == "UIS0004"
            assert offer.refused.partition(":")[0] == result.message.partition(":")[0]
            return verdict((s, text.partition(":")[0]) for s, text in texts)
        if not given.key:
            assert not offer.refused
        name = f"{source.instance}.one_{target.instance}.other"
        inspected = page.done("adjusted", ui.Adjust(name, [], False))
        lines = inspected.text.splitlines()
        for severity, text in texts:
            assert severity == "error" or any(map(text.startswith, lines))
        return verdict((s, text.partition(":")[0]) for s, text in texts)
    finally:
        bench.close()


WIRED, TIMED = "wired/system.xml", "timed/system.xml"
ASKERS: Final[dict[str, Asker]] = {
    "lint": command("lint", file=WIRED, source=True),
    "lint of a system": command("lint", WIRED, file=WIRED),
    "check": command("check", file=WIRED, source=True),
    "check of a system": command("check", WIRED, file=WIRED),
    "inspect": command("inspect", WIRED, "ends.idl", file=WIRED),
    "inspect of a system alone": command("inspect", WIRED, file=WIRED),
    "generate": command(
        *("generate", "--target", "openrtm", "-o", "openrtm"), file=WIRED, source=True
    ),
    "run": command("run", WIRED, "--until", "0.05", file=WIRED),
    "replay": command("replay", "own.mcap", "--into", WIRED, file=WIRED),
    "graph": command("graph", WIRED, "-o", "wired.svg", file=WIRED),
    "language server": language_server,
    "page": opened_page(WIRED),
    "page that connects": page_that_connects,
    "run of a timeline": command("run", "timed", "--until", "0.05", file=TIMED),
    "lint of a timeline": command("lint", file=TIMED, source=True),
    "check of a timeline": command("check", file=TIMED, source=True),
    "page with a timeline": opened_page("timed"),
}


@pytest.mark.sampled(11)
@pytest.mark.parametrize("asker", ASKERS)
@pytest.mark.parametrize("pair", BY_NAME, indirect=True)
def test_every_asker_has_the_same_verdict(
    pair: Pair, asker: str, capfd: pytest.CaptureFixture[str]
) -> None:
    assert ASKERS[asker](pair, capfd) == pair.verdict


@pytest.mark.parametrize(
    "pair", ["dimension", "scale", "type", "allowed"], indirect=True
)
def test_a_running_system_is_listed_with_the_verdict(
    pair: Pair, capfd: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("zenoh", reason="rtgen ctl needs a transport: eclipse-zenoh")
    listed = command(
        *("ctl", "list", "--transport", "zenoh", "--wait", "0.05"),
        *("--system", WIRED),
        file=WIRED,
    )
    assert listed(pair, capfd) == pair.verdict


@pytest.mark.parametrize("pair", ["type", "interface"], indirect=True)
@pytest.mark.parametrize("folder", ["wired", "timed"])
def test_a_run_leaves_out_what_only_other_programs_join(
    pair: Pair, folder: str, capfd: pytest.CaptureFixture[str]
) -> None:
    allowed = pair._replace(key="rtgen.allow.RTC0582", text=REASON)
    Path("wired/system.xml").write_text(system(allowed, connected=True))
    Path("timed/timeline.toml").write_text(timeline(allowed))
    assert run(["run", folder, "--until", "0.05"]) == 0
    said = capfd.readouterr().err
    assert "warning[SYS0003]" in said
    assert f"it is left out: {REASON}" in said


BY_HAND = """
from rtgen.runtime import Component, ComponentProfile, PortProfile
from rtgen.runtime.library.rtc import TimedDouble


def port(kind, name, unit):
    return PortProfile(name, name, kind, "RTC::TimedDouble", "", unit=unit)


class ByHand(Component):
    ports = port("outport", "given", "m"), port("inport", "taken", "s")
    profile = ComponentProfile("ByHand", ports=ports)

    def __init__(self, instance_name=None):
        super().__init__(instance_name)
        self.given = self.add_out_port("given", TimedDouble)
        self.taken = self.add_in_port("taken", TimedDouble)
"""


def test_a_page_compares_what_profiles_state(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", list(sys.path))
    Path("src").mkdir()
    Path("src/judged_by_hand.py").write_text(BY_HAND)
    Path("rtgen.toml").write_text('[components]\nByHand = "judged_by_hand:ByHand"\n')
    Path("s.xml").write_text(
        SYSTEM.format(source="ByHand", target="ByHand", connector="").replace(
            "ByHand0", "A0", 1
        )
    )
    bench = Bench("s.xml")
    try:
        page = bench.page()
        given, taken = ui.PortAddress("A0", "given"), ui.PortAddress("ByHand0", "taken")
        for here, there in ((given, taken), (taken, given)):
            offers = {
                (f.port.instance, f.port.port): f for f in page.done("ends", here).fits
            }
            offer = offers[there.instance, there.port]
            assert offer.allow == "RTC0593"
            assert "A0.given gives m, ByHand0.taken takes s" in offer.refused
            assert page.ask("wire", ui.Connect(here, there, "", [])).code == "UIS0004"
        reason = [ui.Value("rtgen.allow.RTC0593", REASON)]
        page.done("wire", ui.Connect(given, taken, "", reason))
    finally:
        bench.close()
