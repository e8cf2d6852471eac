"""Plug-ins by name: misspelt ones, those of other kernels, and files of one's own."""

from __future__ import annotations

from pathlib import Path

import pytest

from rtgen.cli import run
from rtgen.compiler.diagnostics import Diagnostic
from rtgen.compiler.frontends.cdl import load
from rtgen.compiler.frontends.cdl.passes.plugins import TECSGEN, is_known, nearest

BOARD = """
signature sMove {{ int32_t go( [in] int32_t x ); }};
celltype tServer {{ entry sMove eMove; }};
[active] celltype tClient {{ call sMove cMove; }};
cell tServer Server {{}};
cell tClient Client {{ [through( {plugin}, "" )] cMove = Server.eMove; }};
"""

MISSPELT = {
    **dict.fromkeys(
        [
            *("RTCPlugins", "RTPPlugin", "RtcPlugin", "RTCplugin", "RTCPlug", "RTC"),
            *("RTCPluggin", "RTCPlugn", "RCTPlugin", "RTCPlug_in", "RTMPlugin"),
            *("RTCCPlugin", "rtcplugin", "RTCPlguin", "RTC_Plugin", "RTCPlugIn"),
        ],
        "RTCPlugin",
    ),
    "OpaqueRpcPlugin": "OpaqueRPCPlugin",
    "OpaqueRPCPlugins": "OpaqueRPCPlugin",
    "OpaqeRPCPlugin": "OpaqueRPCPlugin",
    "OpaqueRPC": "OpaqueRPCPlugin",
    "TracePlugn": "TracePlugin",
    "SharedOpaqueRPCPlug": "SharedOpaqueRPCPlugin",
}

OTHERS = [
    *("OwnPlugin", "LoggerPlugin", "ROSPlugin", "HRP3TaskPlugin", "HRMP3Plugin"),
    *("FMP3Plugin", "ATK2TaskPlugin", "EV3Plugin", "X", "Plugin"),
]


def findings(folder: Path, plugin: str, *include: Path) -> list[Diagnostic]:
    """Return the findings about plug-ins of a board whose join has this one."""
    folder.mkdir(exist_ok=True)
    file = folder / "board.cdl"
    file.write_text(BOARD.format(plugin=plugin))
    result = load([file], root=folder, include=include)
    return [d for d in result.diagnostics if d.code.startswith("CDL071")]


@pytest.mark.parametrize(("written", "meant"), MISSPELT.items())
def test_a_misspelt_plug_in_is_an_error(
    written: str, meant: str, tmp_path: Path
) -> None:
    (found,) = findings(tmp_path, written)
    assert (found.code, found.severity) == ("CDL0716", "error")
    assert found.hint is not None
    assert found.hint.startswith(f"did you mean {meant}?")


@pytest.mark.parametrize("name", OTHERS)
def test_an_unknown_plug_in_is_left_to_tecsgen(name: str, tmp_path: Path) -> None:
    (found,) = findings(tmp_path, name)
    assert (found.code, found.severity) == ("CDL0710", "warning")


@pytest.mark.parametrize("name", sorted(TECSGEN))
def test_plug_ins_of_tecsgen_are_known(name: str, tmp_path: Path) -> None:
    assert is_known(name)
    assert nearest(name) == name
    assert findings(tmp_path, name) == []


@pytest.mark.parametrize("place", ["beside", "include"])
def test_a_plug_in_whose_file_is_found_is_known(place: str, tmp_path: Path) -> None:
    library = tmp_path / "library"
    library.mkdir()
    board = tmp_path / "board"
    board.mkdir()
    for name in ("RTCPlugins", "LoggerPlugin"):
        assert len(findings(board, name, library)) == 1
        folder = board if place == "beside" else library
        (folder / f"{name}.rb").write_text("class X < ThroughPlugin; end\n")
        assert findings(board, name, library) == []


def test_nothing_is_removed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    file = tmp_path / "board.cdl"
    file.write_text(BOARD.format(plugin="RTCPlugin"))
    assert run(["generate", "board.cdl", "-q"]) == 0
    before = {p: p.read_bytes() for p in tmp_path.rglob("*") if p.is_file()}
    assert len(before) > 10
    file.write_text(BOARD.format(plugin="RTCPlugins"))
    before[file] = file.read_bytes()
    for command in ("generate", "check", "lint"):
        capfd.readouterr()
        assert run([command, "board.cdl"]) == 2
        assert "did you mean RTCPlugin?" in capfd.readouterr().err
    assert {p: p.read_bytes() for p in tmp_path.rglob("*") if p.is_file()} == before


CELLS = """
signature sMove {{ int32_t go( [in] int32_t x ); }};
celltype tServer {{ entry sMove eMove; }};
[active] celltype tClient {{ call sMove cMove[2]; }};
{server}cell tServer Server {{}};
{client}cell tClient Client {{
  cMove[0] = Server.eMove;
  cMove[1] = Server.eMove;
}};
"""
LINE = '[through( RTCPlugin, "" )] '


@pytest.mark.parametrize("where", ["server", "client"])
def test_through_in_front_of_a_cell(where: str, tmp_path: Path) -> None:
    """The hint is the line that was meant; the join is shown."""
    places = {"server": "", "client": "", where: LINE}
    file = tmp_path / "board.cdl"
    file.write_text(CELLS.format(**places))
    (found,) = (
        d for d in load([file], root=tmp_path).diagnostics if d.code == "CDL0214"
    )
    assert found.hint is not None
    assert found.hint.endswith(f"in front of the join: {LINE}cMove = Server.eMove;")
    assert [r.span.line for r in found.related] == [7]


@pytest.mark.parametrize(
    ("text", "hint"),
    [
        (f"{LINE}signature sX {{ void f( void ); }};", "a join in a cell"),
        (f"{LINE}celltype tX {{ entry sMove eX; }};", "a join in a cell"),
        (f"celltype tX {{ {LINE}entry sMove eX; }};", "a join in a cell"),
        (f"{LINE}region rX {{ cell tServer X {{}}; }};", "a join in a cell"),
        (f"{LINE}cell tServer Alone {{}};", "a join in a cell"),
        ("[oneway] signature sX { void f( void ); };", "a function"),
        ("signature sX { [singleton] void f( void ); };", "a celltype or composite"),
        ("signature sX { void f( [id( 3 )] int32_t a ); };", "a cell"),
        ("struct tX { [in] int32_t a; };", "a parameter"),
        ("[linkunit] cell tServer Alone {};", "a region"),
    ],
)
def test_the_hint_says_where_a_specifier_belongs(
    text: str, hint: str, tmp_path: Path
) -> None:
    file = tmp_path / "board.cdl"
    file.write_text(BOARD.format(plugin="RTCPlugin") + text)
    found = [d for d in load([file], root=tmp_path).diagnostics if d.code == "CDL0214"]
    assert len(found) == 1
    assert f"belongs in front of {hint}" in (found[0].hint or "")


@pytest.mark.parametrize(
    "join",
    [
        'cMove = [through( RTCPlugin, "" )] Server.eMove;',
        'cMove = Server.eMove [through( RTCPlugin, "" )];',
        'through( RTCPlugin, "" ) cMove = Server.eMove;',
    ],
)
def test_through_in_another_place_of_a_join(join: str, tmp_path: Path) -> None:
    file = tmp_path / "board.cdl"
    file.write_text(
        CELLS.format(server="", client="") + f"cell tClient X {{ {join} }};"
    )
    hints = [d.hint or "" for d in load([file], root=tmp_path).diagnostics]
    assert any(h.startswith("through is in brackets in front of a join") for h in hints)
