"""Hover, hints, symbols, tokens, folding, completion and code actions."""

from __future__ import annotations

from pathlib import Path

import pytest
from editor import Editor
from lsprotocol.types import (
    DocumentSymbol,
    MarkupContent,
    Position,
    Range,
    WorkspaceEdit,
)
from projects import PROJECT

from rtgen.tools.fmt import format_text
from rtgen.tools.fmt.files import format_bytes
from rtgen.tools.fmt.tokens import Language as Form
from rtgen.tools.lsp.features.code_actions import code_actions
from rtgen.tools.lsp.features.completion import completion
from rtgen.tools.lsp.features.diagnostics import published
from rtgen.tools.lsp.features.folding import folding
from rtgen.tools.lsp.features.formatting import formatting
from rtgen.tools.lsp.features.hover import hover
from rtgen.tools.lsp.features.inlay_hints import inlay_hints
from rtgen.tools.lsp.features.semantic_tokens import LEGEND, semantic_tokens
from rtgen.tools.lsp.features.symbols import document_symbols, workspace_symbols
from rtgen.tools.lsp.workspace import View

ALL = Range(Position(0, 0), Position(10_000, 0))


@pytest.fixture
def editor(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Editor:
    monkeypatch.chdir(tmp_path)
    return Editor(tmp_path, **PROJECT)


def hovered(editor: Editor, view: View, place: str) -> str:
    found = hover(view, editor.at(view, place))
    assert found is not None
    assert isinstance(found.contents, MarkupContent)
    return found.contents.value


@pytest.mark.sampled(4)
@pytest.mark.parametrize(
    ("file", "place", "wanted"),
    [
        (
            "drawing_idl",
            "consumes Shapes::Poi^nt where",
            [
                "struct Shapes::Point",
                "| 0 | 8 | x |",
                "| 16 | 1 | quality |",
                "| 20 |  | tags |",
                "CDR: variable",
                "A point of the floor.",
            ],
        ),
        (
            "types_idl",
            "double x^;",
            ["offset 0, 8 octets", "most: 9.0", "unit: m", "To the front."],
        ),
        (
            "types_idl",
            "Point> Poi^nts",
            ["typedef sequence<Shapes::Point> Shapes::Points"],
        ),
        ("types_idl", "RED, GRE^EN", ["GREEN = 1"]),
        ("types_idl", "long MO^ST", ["const long Shapes::MOST = 4"]),
        ("drawing_idl", "void dra^w(", ["void draw(in Shapes::Points points"]),
        ("drawing_idl", "in Shapes::Points poin^ts,", ["// sequence<Shapes::Point>"]),
        ("drawing_idl", "double wid^th", ["default: 2.5"]),
        ("drawing_idl", "component Paint^er", ["inport Shapes::Point where"]),
        ("system_xml", 'dataType="Shapes::Poi^nt"', ["struct Shapes::Point"]),
        ("board_cdl", "int32_t dri^ve(", ["function id 1", "| left | in | 4 octets |"]),
        ("board_cdl", "cell tTa^sk Task", ["celltype tTask"]),
        (
            "bus_toml",
            '"20^00" = "m/s"',
            ["2000h Speed", "INTEGER16, 16 bits, ro", "TPDO 1: bit 0, 16 bits"],
        ),
        ("bus_toml", "bit_^rate = 500", ["In kbit/s."]),
    ],
)
def test_hover(editor: Editor, file: str, place: str, wanted: list[str]) -> None:
    text = hovered(editor, editor.open(file), place)
    assert [line for line in wanted if line not in text] == [], text


def test_hover_of_widths_that_tdr_defines(editor: Editor) -> None:
    text = editor.path("board_cdl").read_text(encoding="utf-8")
    other = text.replace("[in] speed_t left", "[in] short_t left, [in] int_t middle")
    view = editor.open("board_cdl", other)
    shown = hovered(editor, view, "int32_t dri^ve(")
    rows = ["| left | in | 2 octets |", "| middle | in | 4 octets |"]
    assert [row for row in rows if row not in shown] == [], shown


def test_hover_of_a_code_in_the_settings(editor: Editor) -> None:
    text = editor.path("rtgen_toml").read_text() + '[lint]\nignore = ["LINT0001"]\n'
    view = editor.open("rtgen_toml", text)
    assert "LINT0001" in hovered(editor, view, "LINT^0001")


def test_no_hover_in_a_comment(editor: Editor) -> None:
    view = editor.open("types_idl")
    assert hover(view, editor.at(view, "/// A poi^nt")) is None


def test_hints_of_offsets(editor: Editor) -> None:
    view = editor.open("types_idl")
    hints = inlay_hints(view, ALL)
    assert [(h.position.line + 1, h.label) for h in hints] == [
        (4, "offset 0, 8 octets"),
        (5, "offset 8, 8 octets"),
        (6, "offset 16, 1 octet"),
        (7, "offset 20, variable"),
    ]
    assert inlay_hints(view, Range(Position(5, 0), Position(6, 0))) == hints[2:3]


def test_hover_of_structs_nested_too_deeply(editor: Editor) -> None:
    """IDL0314 reports them; their offsets are missing then."""
    lines = ["struct S0 { octet a; };"]
    lines += [f"struct S{n} {{ S{n - 1} a; }};" for n in range(1, 500)]
    view = editor.open("types_idl", "\n".join(lines))
    assert "CDR: 1 octet" in hovered(editor, view, "struct S5^0 ")
    assert "struct S499" in hovered(editor, view, "struct S49^9 ")


def test_hints_of_a_pdo(editor: Editor) -> None:
    view = editor.open("drive_eds")
    assert [h.label for h in inlay_hints(view, ALL)] == ["Speed: bit 0, 16 bits"]


def outline(symbols: list[DocumentSymbol]) -> list[object]:
    return [(s.name, outline([*s.children])) if s.children else s.name for s in symbols]


def test_document_symbols(editor: Editor) -> None:
    view = editor.open("drawing_idl")
    assert outline(document_symbols(view)) == [
        (
            "Drawing",
            [("Canvas", ["draw"]), ("Painter", ["where", "last", "canvas", "width"])],
        )
    ]


@pytest.mark.parametrize("file", list(PROJECT))
def test_symbols_lie_inside_each_other(editor: Editor, file: str) -> None:
    def check(symbols: list[DocumentSymbol], around: Range) -> None:
        for symbol in symbols:
            whole, name = symbol.range, symbol.selection_range
            places = (around.start, whole.start, name.start)
            assert [*places] == sorted(places, key=lambda p: (p.line, p.character))
            places = (name.end, whole.end, around.end)
            assert [*places] == sorted(places, key=lambda p: (p.line, p.character))
            check([*(symbol.children or ())], whole)

    found = document_symbols(editor.open(file))
    assert found
    check(found, ALL)


def test_workspace_symbols(editor: Editor) -> None:
    editor.open("types_idl")
    found = workspace_symbols(editor.workspace, "point")
    assert [s.name for s in found][:2] == ["Point", "Points"]
    assert found[0].container_name == "Shapes"
    assert workspace_symbols(editor.workspace, "zzz") == []


def test_semantic_tokens(editor: Editor) -> None:
    view = editor.open("types_idl")
    data = [*semantic_tokens(view).data]
    line = character = 0
    found = []
    for index in range(0, len(data), 5):
        down, right, length, kind, modifiers = data[index : index + 5]
        line, character = line + down, right + (0 if down else character)
        place = Range(Position(line, character), Position(line, character + length))
        name = editor.text(view.document.path, place)
        found.append((name, LEGEND.token_types[kind], modifiers))
    assert ("Point", "struct", 1) in found
    assert ("Point", "struct", 0) in found
    assert ("RED", "enumMember", 1) in found
    assert ("MOST", "variable", 3) in found
    assert len(found) == 12


def test_semantic_tokens_of_a_range(editor: Editor) -> None:
    view = editor.open("types_idl")
    some = semantic_tokens(view, Range(Position(8, 0), Position(9, 0)))
    assert len(some.data) == 2 * 5


@pytest.mark.parametrize(
    ("file", "wanted"),
    [
        ("types_idl", [(0, 10), (2, 6)]),
        ("board_cdl", [(5, 7), (10, 12), (16, 17), (20, 21), (24, 25)]),
        ("bus_toml", [(0, 1), (3, 6), (8, 10), (12, 13)]),
    ],
)
def test_folding(editor: Editor, file: str, wanted: list[tuple[int, int]]) -> None:
    found = [(f.start_line, f.end_line) for f in folding(editor.open(file))]
    assert found == wanted


@pytest.mark.sampled(4)
@pytest.mark.parametrize(
    ("file", "at", "typed", "wanted", "unwanted"),
    [
        ("drawing_idl", "    consumes ^^Shapes", "Shapes::", {"Point"}, {"Canvas", "MOST"}),
        ("drawing_idl", "    ^^consumes", "", {"provides"}, {"Point", "Canvas"}),
        ("drawing_idl", "    ^^consumes", "@de", {"name", "port"}, {"Shapes", "default", "id"}),
        ("drawing_idl", '#include "^^types', "", {"types.idl", "BasicDataType.idl"}, set()),
        ("board_cdl", "cMotor = ^Motor.eMotor^;", "Motor.", {"eMotor"}, {"cMotor"}),
        ("board_cdl", "cell ^tTask^ Task", "t", {"tTask", "tMotor"}, {"sMotor"}),
        ("board_cdl", "call ^sMotor^ cMotor", "s", {"sMotor"}, {"tMotor"}),
        ("board_cdl", "    ^cMotor^ = Motor", "c", {"cMotor"}, {"sMotor", "eMotor"}),
        ("bus_toml", "^^bit_rate", "", {"sync", "manager"}, {"eds"}),
        ("bus_toml", '^^"1017" = 200', "", {"1017", "2000"}, {"sync"}),
        ("bus_toml", 'device = "^wheel^"', "", {"wheel"}, set()),
        ("bus_toml", "bit_rate = ^500^", "", {"125", "500"}, set()),
        ("rtgen_toml", "^^include", "", {"define", "prelude"}, {"package"}),
        ("system_xml", 'dataType="^Shapes::Point^"', "Sh", {"Shapes::Point"}, set()),
        ("drive_eds", "^^ParameterName=Speed", "", {"DefaultValue"}, set()),
    ],
)  # fmt: skip
def test_completion(
    editor: Editor, file: str, at: str, typed: str, wanted: set[str], unwanted: set[str]
) -> None:
    source = editor.open(file).text.source
    view = editor.edit(file, at, typed)
    before = source.index(at.replace("^", "")) + len(at.partition("^")[0])
    offset = before + len(typed)
    found = completion(view, view.range(offset, offset).start)
    labels = {item.label for item in found.items}
    assert wanted <= labels, labels
    assert not unwanted & labels


def test_code_actions_of_hints(editor: Editor) -> None:
    text = PROJECT["drawing_idl"].replace("Shapes::Points", "Shapes::Pointsz")
    view = editor.open("drawing_idl", text)
    findings = editor.findings("drawing_idl")["drawing.idl"]
    shown = published(editor.workspace, view.document.path, findings)
    actions = code_actions(editor.view("drawing_idl"), ALL, shown)
    assert [a.title for a in actions] == ["Change Pointsz to Points"]
    assert actions[0].edit is not None
    assert editor.applied(actions[0].edit)["drawing.idl"] == PROJECT["drawing_idl"]


def test_a_code_action_includes_a_file(editor: Editor) -> None:
    text = PROJECT["drawing_idl"].removeprefix('#include "types.idl"\n')
    view = editor.open("drawing_idl", text.replace("Shapes::Point", "Point"))
    findings = editor.findings("drawing_idl")["drawing.idl"]
    shown = published(editor.workspace, view.document.path, findings)
    titles = {a.title for a in code_actions(editor.view("drawing_idl"), ALL, shown)}
    assert titles == {'Add #include "types.idl"'}


def test_code_actions_of_safe_fixes(editor: Editor) -> None:
    text = PROJECT["types_idl"].replace("octet quality;", "octet quality;;")
    editor.open("types_idl", text)
    view = editor.edit("types_idl", "^^module Shapes", "// moved\n")
    actions = code_actions(view, ALL, [])
    assert [a.title for a in actions] == [
        "Remove the ';' (IDL0110)",
        "Fix all that rtgen can fix safely",
    ]
    for action in actions:
        assert action.edit is not None
        fixed = editor.applied(action.edit)["types.idl"]
        assert fixed == "// moved\n" + PROJECT["types_idl"]
    assert code_actions(view, Range(Position(0, 0), Position(0, 0)), []) == actions[1:]


@pytest.mark.parametrize("end", ["\n", "\r\n"])
@pytest.mark.parametrize("file", ["drawing_idl", "board_cdl"])
def test_formatting(editor: Editor, file: str, end: str) -> None:
    untidy = PROJECT[file].replace("    ", "\t ").replace(" {", "   {")
    view = editor.open(file, untidy.replace("\n", end))
    form = Form.IDL if file == "drawing_idl" else Form.CDL
    wanted = format_text(untidy, form).replace("\n", end)
    edit = WorkspaceEdit(changes={view.document.uri: formatting(view)})
    assert list(editor.applied(edit).values()) == [wanted]
    assert formatting(editor.open(file, wanted)) == []


@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_formatting_of_a_bus_file(editor: Editor, end: str) -> None:
    tidy = PROJECT["bus_toml"]
    view = editor.open("bus_toml", tidy.replace(" = ", "=").replace("\n", end))
    edit = WorkspaceEdit(changes={view.document.uri: formatting(view)})
    [formed] = editor.applied(edit).values()
    assert formed == format_bytes(tidy.encode(), "bus.toml").decode().replace("\n", end)
    assert formatting(editor.open("bus_toml", formed)) == []
    assert formatting(editor.open("bus_toml", "[bus\n")) == []


def test_formatting_of_a_range(editor: Editor) -> None:
    view = editor.open("board_cdl", PROJECT["board_cdl"].replace("    ", "  "))
    lines = Range(Position(17, 0), Position(17, 99))
    edit = WorkspaceEdit(changes={view.document.uri: formatting(view, lines)})
    text = editor.applied(edit)["board.cdl"]
    assert "    call sMotor cMotor;" in text
    assert "\n  entry sMotor eMotor;" in text


@pytest.mark.sampled(0)
def test_what_has_no_form_is_left(editor: Editor) -> None:
    assert formatting(editor.open("types_idl", 'struct A { "\n')) == []
    assert formatting(editor.open("drive_eds")) == []
