"""Definition, references, rename and highlights, in and across languages."""

from __future__ import annotations

from pathlib import Path

import pytest
from editor import Editor
from projects import PROJECT

from rtgen.tools.lsp.features.definition import definition
from rtgen.tools.lsp.features.references import highlights, references
from rtgen.tools.lsp.features.rename import prepared, renamed
from rtgen.tools.renaming.definitions import RenameError


@pytest.fixture
def editor(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Editor:
    monkeypatch.chdir(tmp_path)
    return Editor(tmp_path, **PROJECT)


@pytest.mark.sampled(5)
@pytest.mark.parametrize(
    ("file", "place", "wanted"),
    [
        ("drawing_idl", "in Shapes::Poi^nts points", ["types.idl:9 Points"]),
        ("drawing_idl", "in Sha^pes::Points", ["types.idl:1 Shapes"]),
        ("drawing_idl", '#include "ty^pes.idl"', ["types.idl:1 "]),
        ("drawing_idl", "provides Can^vas canvas", ["drawing.idl:4 Canvas"]),
        ("system_xml", 'dataType="Shapes::Poi^nt"', ["types.idl:3 Point"]),
        (
            "system_xml",
            'rts:instanceName="painter0" rts:id="RTC:::Pain^ter',
            ["drawing.idl:7 Painter"],
        ),
        (
            "system_xml",
            'rts:portName="painter0.la^st" rts:instanceName',
            ["drawing.idl:9 last"],
        ),
        ("board_cdl", "cMotor = Mot^or.eMotor", ["board.cdl:21 Motor"]),
        ("board_cdl", "cMotor = Motor.eMot^or", ["board.cdl:12 eMotor"]),
        ("board_cdl", "cMot^or = Motor", ["board.cdl:18 cMotor"]),
        ("board_cdl", "entry sMot^or eMotor", ["board.cdl:6 sMotor"]),
        ("board_cdl", "[in] speed^_t left", ["board.cdl:1 speed_t"]),
        ("board_cdl", "string(SI^ZE)", ["board.cdl:2 SIZE"]),
        ("bus_toml", 'parameters = ["10^17"]', ["drive.eds:48 1017"]),
        ("bus_toml", '"20^00" = "m/s"', ["drive.eds:119 2000"]),
        ("bus_toml", 'device = "whe^el"', ["bus.toml:4 wheel"]),
        ("bus_toml", 'eds = "drive^.eds"', ["drive.eds:1 "]),
        ("drive_eds", "DefaultValue=0x2000^0010", ["drive.eds:119 2000"]),
    ],
)
def test_definition(editor: Editor, file: str, place: str, wanted: list[str]) -> None:
    view = editor.open(file)
    found = definition(view, editor.at(view, place))
    assert [editor.shown(each).replace("[", "").replace("]", "") for each in found] == (
        wanted
    )


def test_a_place_without_a_name_has_no_definition(editor: Editor) -> None:
    view = editor.open("types_idl")
    assert definition(view, editor.at(view, "/// A po^int")) == []


def test_references_of_a_type_in_other_languages(editor: Editor) -> None:
    view = editor.open("types_idl")
    position = editor.at(view, "struct Po^int")
    assert {editor.shown(e) for e in references(view, position, declaration=True)} == {
        "types.idl:3 Point",
        "types.idl:9 Point",
        "drawing.idl:8 Point",
        "drawing.idl:9 Point",
        "system.xml:13 Point",
    }
    without = references(view, position, declaration=False)
    assert "types.idl:3 Point" not in {editor.shown(e) for e in without}


def test_rename_changes_all_uses(editor: Editor) -> None:
    view = editor.open("types_idl")
    position = editor.at(view, "struct Po^int")
    placeholder = prepared(view, position)
    assert placeholder is not None
    assert placeholder.placeholder == "Point"
    changed = editor.applied(renamed(view, position, "Spot"))
    assert set(changed) == {"types.idl", "drawing.idl", "system.xml"}
    assert "struct Spot {" in changed["types.idl"]
    assert "typedef sequence<Spot> Points;" in changed["types.idl"]
    assert "consumes Shapes::Spot where;" in changed["drawing.idl"]
    assert 'rts:dataType="Shapes::Spot"' in changed["system.xml"]


def test_what_is_renamed_is_read_without_findings(editor: Editor) -> None:
    view = editor.open("board_cdl")
    changed = editor.applied(
        renamed(view, editor.at(view, "entry sMotor eMot^or"), "ePort")
    )
    assert changed["board.cdl"].count("ePort") == 2
    editor.open("board_cdl", changed["board.cdl"])
    assert editor.findings("board_cdl")["board.cdl"] == []


@pytest.mark.parametrize(
    ("name", "reason"),
    [
        ("two words", "is not a name"),
        ("struct", "is a keyword of IDL"),
        ("points", "there is a typedef Points beside it"),
    ],
)
def test_names_that_cannot_be(editor: Editor, name: str, reason: str) -> None:
    view = editor.open("types_idl")
    with pytest.raises(RenameError, match=reason):
        renamed(view, editor.at(view, "struct Po^int"), name)


def test_a_name_from_a_macro_is_not_renamed(editor: Editor) -> None:
    text = "#define NAME Thing\nstruct NAME { long a; };\ntypedef NAME Other;\n"
    editor.path("macro_idl").write_text(text)
    view = editor.open("macro_idl")
    with pytest.raises(RenameError, match="macro"):
        renamed(view, editor.at(view, "typedef NA^ME"), "Else")


def test_highlights_tell_definition_from_use(editor: Editor) -> None:
    view = editor.open("types_idl")
    found = highlights(view, editor.at(view, "struct Po^int"))
    assert [h.range.start.line + 1 for h in found] == [3, 9]
    assert found[0].kind is not found[1].kind


def test_answers_move_with_edits_that_are_not_analysed(editor: Editor) -> None:
    editor.open("types_idl")
    view = editor.edit("types_idl", "^^module Shapes", "// new\n\n// lines\n")
    found = references(view, editor.at(view, "struct Po^int"), declaration=True)
    assert "types.idl:6 Point" in {editor.shown(each) for each in found}
    view = editor.open("drawing_idl")
    found = definition(view, editor.at(view, "consumes Shapes::Po^int"))
    assert [editor.shown(each) for each in found] == ["types.idl:6 Point"]


def test_edits_far_apart_leave_what_is_between_them(editor: Editor) -> None:
    editor.open("types_idl")
    editor.edit("types_idl", "module Sha^^pes", "")
    editor.edit("types_idl", "^^  /// A point", "  // first\n")
    view = editor.edit("types_idl", "MOST = ^4^;", "12")
    found = renamed(view, editor.at(view, "struct Po^int"), "Spot")
    text = editor.applied(found)["types.idl"]
    assert "struct Spot {" in text
    assert "typedef sequence<Spot> Points;" in text
    assert "MOST = 12;" in text


def test_names_of_a_file_that_several_include_follow_the_edits_of_each(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    user = '#include "parts.idl"\nstruct {0} {{ Part part; }};\n'
    monkeypatch.chdir(tmp_path)
    editor = Editor(
        tmp_path,
        parts_idl="#pragma once\nstruct Part { long size; };\n",
        one_idl=user.format("One"),
        two_idl=user.format("Two"),
    )

    def places(file: str, marked: str) -> list[str]:
        view = editor.analysed(file)
        uses = references(view, editor.at(view, marked), declaration=True)
        return sorted(map(editor.shown, uses))

    in_one, own, in_two = "one.idl:2 Part", "parts.idl:2 Part", "two.idl:2 Part"
    for file in ("parts_idl", "one_idl", "two_idl"):
        editor.open(file)
    editor.edit("one_idl", "struct ^One^", "First")
    assert places("two_idl", "{ Pa^rt") == [in_one, own, in_two]
    editor.edit("one_idl", '^#include "parts.idl"^', "")
    editor.edit("one_idl", "^Part^ part", "long")
    assert places("two_idl", "{ Pa^rt") == [own, in_two]
    editor.edit("parts_idl", "struct ^Part^", "Piece")
    editor.edit("two_idl", "^Part^ part", "Piece")
    assert places("parts_idl", "struct Pie^ce") == [
        "parts.idl:2 Piece",
        "two.idl:2 Piece",
    ]


@pytest.mark.sampled(1)
@pytest.mark.parametrize("header", ["[device.wheel]", '[device."wheel"]'])
def test_a_device_of_a_bus_with_tables_in_it(editor: Editor, header: str) -> None:
    text = editor.path("bus_toml").read_text().replace("[device.wheel]", header)
    text += header.replace("]", ".values]") + '\n"1017" = 100\n'
    view = editor.open("bus_toml", text)
    position = editor.at(view, 'device = "whe^el"')
    changed = editor.applied(renamed(view, position, "caster"))
    assert "wheel" not in changed["bus.toml"]
    editor.open("bus_toml", changed["bus.toml"])
    found = editor.findings("bus_toml")["bus.toml"]
    assert [each for each in found if each.severity.value == "error"] == []


PROFILE = """\
<rtc:RtcProfile rtc:version="0.3" rtc:id="RTC:me:Demo:Lamp:1.0.0"
    xmlns:rtc="http://www.openrtp.org/namespaces/rtc">
  <rtc:BasicInfo rtc:name="Lamp" rtc:componentType="STATIC" rtc:activityType="PERIODIC"
      rtc:componentKind="DataFlowComponent" rtc:category="Demo" rtc:vendor="me"
      rtc:version="1.0.0" rtc:executionType="PeriodicExecutionContext"
      rtc:executionRate="10.0" rtc:maxInstances="1"
      rtc:creationDate="2024-05-06T07:08:09+09:00"
      rtc:updateDate="2024-05-06T07:08:09+09:00"/>
  <rtc:ConfigurationSet>
    <rtc:Configuration rtc:name="glow" rtc:type="double" rtc:defaultValue="0.5"/>
  </rtc:ConfigurationSet>
  <rtc:DataPorts rtc:portType="DataInPort" rtc:name="spot" rtc:type="Shapes::Point"/>
  <rtc:ServicePorts rtc:name="Board">
    <rtc:ServiceInterface rtc:name="canvas" rtc:direction="Required"
        rtc:type="Drawing::Canvas"/>
  </rtc:ServicePorts>
  <rtc:Language rtc:kind="Python"/>
</rtc:RtcProfile>
"""


def test_names_of_a_profile(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    editor = Editor(tmp_path, **PROJECT, lamp_xml=PROFILE)
    view = editor.open("types_idl")
    point = editor.at(view, "struct Po^int")
    shown = {editor.shown(e) for e in references(view, point, declaration=False)}
    assert "lamp.xml:12 Point" in {
        each.replace("[", "").replace("]", "") for each in shown
    }
    view = editor.open("drawing_idl")
    canvas = editor.at(view, "provides Can^vas canvas")
    shown = {editor.shown(e) for e in references(view, canvas, declaration=False)}
    assert any(each.startswith("lamp.xml:15 ") for each in shown)
