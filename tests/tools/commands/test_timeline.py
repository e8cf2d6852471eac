"""Timelines: planned actions of a run."""

from __future__ import annotations

from pathlib import Path

import pytest

from rtgen.compiler.diagnostics import Diagnostic, InputError, Severity, Span, ToolError
from rtgen.compiler.model import Connection, PortReference, System, SystemComponent
from rtgen.compiler.systems.conditions import SECOND, Condition, condition
from rtgen.compiler.systems.timeline import (
    Connect,
    Disconnect,
    SetParameter,
    StateRequest,
    assignment,
    load,
    parse,
)

SPAN = Span("s.xml", 1, 1, 1, 2)
A, B = PortReference(instance="A0", port="out"), PortReference(instance="B0", port="in")
X, Y = PortReference(instance="A0", port="x"), PortReference(instance="B0", port="y")
SYSTEM = System(
    name="S",
    id="",
    file="s.xml",
    abstract="",
    components=tuple(
        SystemComponent(instance=name, type=name[0], id="", path_uri="", span=SPAN)
        for name in ("A0", "B0")
    ),
    connections=(
        Connection(
            name="wire",
            id="7f-3",
            source=A,
            target=B,
            service=False,
            span=SPAN,
            properties=(("dataport.k", "v"),),
        ),
    ),
)


def findings(text: str) -> list[Diagnostic]:
    with pytest.raises(InputError) as error:
        parse(text, "timeline.toml", SYSTEM)
    return list(error.value.diagnostics)


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16", "cp932", "euc_jp"])
def test_a_timeline_in_any_encoding(encoding: str, tmp_path: Path) -> None:
    text = "# 予定の表\n[[at]]\nt = 1.0\nset = \"A0.label = '表示'\"  # 能\n"
    (tmp_path / "t.toml").write_text(text, encoding=encoding, newline="\r\n")
    [step] = load(tmp_path / "t.toml", SYSTEM).steps
    assert "表示" in repr(step.action)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("2.5", Condition(2_500_000_000)),
        ("0", Condition(0)),
        ("A0=error", Condition(None, "A0", "ERROR")),
        ("A0=ACTIVE_STATE, 3", Condition(3 * SECOND, "A0", "ACTIVE")),
    ],
)
def test_conditions(text: str, expected: Condition) -> None:
    assert condition(text, SYSTEM, None) == expected


@pytest.mark.parametrize(
    "text", ["", "soon", "-1", "nan", "inf", "A0=GONE", "1,2", "A0=ERROR,"]
)
def test_wrong_conditions(text: str) -> None:
    with pytest.raises(InputError) as error:
        condition(text, SYSTEM, None)
    assert error.value.diagnostics[0].code == "SYS0006"


def test_a_condition_on_a_component_that_is_not_there() -> None:
    with pytest.raises(InputError) as error:
        condition("A=ERROR", SYSTEM, SPAN)
    assert error.value.diagnostics[0].code == "SYS0005"
    assert error.value.diagnostics[0].hint == "did you mean 'A0'?"


def test_assignments() -> None:
    assert assignment("A0.a.b = 1=2", SYSTEM) == SetParameter("A0", "a.b", "1=2")
    for text in ("A0.gain", "A0=1", "=", "A0.=1"):
        with pytest.raises(InputError) as error:
            assignment(text, SYSTEM)
        assert error.value.diagnostics[0].code == "SYS0004"


def test_a_timeline_in_order_of_time() -> None:
    steps = parse(
        '[[at]]\nt = 2\nactivate = "A0"\nreset = "B0"\nset = ["A0.x=1", "B0.y=2"]\n'
        'connect = "wire"\ndisconnect = "wire"\n[[at]]\nt = 0.5\ndeactivate = "B0"\n'
        'connect = {from = "A0.out", to = "B0.in", properties = {p = "1"}}\n',
        "timeline.toml",
        SYSTEM,
    )
    assert [(s.time / SECOND, s.action) for s in steps] == [
        (0.5, Connect("A0.out-B0.in", A, B, {"p": "1"})),
        (0.5, StateRequest("deactivate", "B0")),
        (2.0, Disconnect("wire")),
        (2.0, Connect("wire", A, B, {"dataport.k": "v"})),
        (2.0, SetParameter("A0", "x", "1")),
        (2.0, SetParameter("B0", "y", "2")),
        (2.0, StateRequest("reset", "B0")),
        (2.0, StateRequest("activate", "A0")),
    ]
    assert [s.span.line for s in steps] == [11, 10, 7, 6, 5, 5, 4, 3]


def actions(text: str) -> list[object]:
    return [s.action for s in parse(f"[[at]]\nt = 1\n{text}", "timeline.toml", SYSTEM)]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ('connect = "7f-3"', [Connect("wire", A, B, {"dataport.k": "v"})]),
        ('disconnect = "7f-3"', [Disconnect("wire")]),
        ('disconnect = {from = "A0.out", to = "B0.in"}', [Disconnect("wire")]),
        ('disconnect = {from = "B0.in", to = "A0.out"}', [Disconnect("wire")]),
        ('connect = {from = "A0.x", to = "B0.y"}', [Connect("A0.x-B0.y", X, Y, {})]),
        (
            '[[at]]\nt = 2\ndisconnect = {to = "B0.y", from = "A0.x"}\n'
            '[[at]]\nt = 1.5\nconnect = {from = "A0.x", to = "B0.y", name = "late"}',
            [Connect("late", X, Y, {}), Disconnect("late")],
        ),
        ('set = {"A0.x" = 2}', [SetParameter("A0", "x", "2")]),
        (
            'set = {A0.x = 0.5, A0.y = true, B0 = {z = [1, 2], n = "a b"}}',
            [
                SetParameter("A0", "x", "0.5"),
                SetParameter("A0", "y", "1"),
                SetParameter("B0", "z", "1,2"),
                SetParameter("B0", "n", "a b"),
            ],
        ),
        ('[at.set]\n"A0.x.y" = -1', [SetParameter("A0", "x.y", "-1")]),
        (
            'set = ["A0.x=1", {B0.x = 2}]',
            [SetParameter("A0", "x", "1"), SetParameter("B0", "x", "2")],
        ),
    ],
)
def test_forms(text: str, expected: list[object]) -> None:
    assert actions(text) == expected


@pytest.mark.parametrize(
    ("text", "code", "line", "message"),
    [
        ("x = [", "SYS0007", 1, "Invalid"),
        ("x = 1", "SYS0007", 1, "'x'"),
        ("at = 1", "SYS0007", 1, "list of tables"),
        ("\n[[at]]\n", "SYS0007", 2, "needs t"),
        ("[[at]]\nt = -1\n", "SYS0007", 2, "needs t"),
        ("[[at]]\nt = true\n", "SYS0007", 2, "needs t"),
        ('[[at]]\nt = 1\nstart = "A0"\n', "SYS0007", 3, "'start'"),
        ("[[at]]\nt = 1\nactivate = 3\n", "SYS0007", 3, "takes names"),
        ("[[at]]\nt = 1\nactivate = {A0 = 1}\n", "SYS0007", 3, "takes names"),
        ("[[at]]\nt = 1\nset = 4\n", "SYS0007", 3, "or a table"),
        ('[[at]]\nt = 1\nset = "A0.x"\n', "SYS0004", 3, "A0.x"),
        ("[[at]]\nt = 1\nset = {A0 = 1}\n", "SYS0004", 3, "A0=1"),
        ("[[at]]\nt = 1\nset = {A0.x = {}}\n", "SYS0004", 3, "cannot be {}"),
        (
            '[[at]]\nt = 1\ndisconnect = {from = "A0.out"}\n',
            "SYS0007",
            3,
            "table of from and to",
        ),
        (
            '[[at]]\nt = 1\nconnect = [{from = "A0.x", to = "B0.y"}, '
            '{from = "A0.x", to = "B0.y", name = "2"}]\n'
            '[[at]]\nt = 2\ndisconnect = {from = "A0.x", to = "B0.y"}\n',
            "SYS0007",
            6,
            "several connections join A0.x and B0.y",
        ),
        (
            '[[at]]\nt = 1\nconnect = {from = "A0", to = "B0.in"}\n',
            "SYS0007",
            3,
            "INSTANCE.PORT",
        ),
        (
            '[[at]]\nt = 1\nconnect = {from = "A0.o\\u001b", to = "B0.in"}\n',
            "SYS0007",
            3,
            "INSTANCE.PORT",
        ),
        ("[[at]]\nt = 1\nconnect = {form = 3}\n", "SYS0007", 3, "table of"),
        ("x = " + "[" * 20000, "SYS0007", 1, "deeply"),
    ],
)
def test_wrong_timelines(text: str, code: str, line: int, message: str) -> None:
    found = findings(text)[0]
    assert found.code == code
    assert found.span is not None
    assert (found.span.file, found.span.line) == ("timeline.toml", line)
    assert message in found.message


@pytest.mark.parametrize(
    ("event", "message", "hint"),
    [
        ('activate = "C0"', "no component 'C0' in the system", "known: A0, B0"),
        ('set = "A00.x=1"', "no component 'A00' in the system", "did you mean 'A0'?"),
        ("set = {C0.x = 1}", "no component 'C0' in the system", "known: A0, B0"),
        ('connect = "wir"', "no connection 'wir' in the system", "known: wire"),
        ('disconnect = "wir"', "no connection 'wir' in the system", "known: wire"),
        (
            'disconnect = {from = "A0.out", to = "B0.y"}',
            "no connection joins A0.out and B0.y",
            "correct the name, or remove the event if the system has changed for good",
        ),
        (
            'connect = {from = "A0.out", to = "C0.y"}',
            "no component 'C0' in the system",
            "known: A0, B0",
        ),
    ],
)
def test_an_event_about_what_the_system_lacks_is_skipped(
    tmp_path: Path, event: str, message: str, hint: str
) -> None:
    file = tmp_path / "t.toml"
    file.write_text(f'[[at]]\nt = 1\n{event}\n[[at]]\nt = 2\nreset = "A0"\n')
    found = load(file, SYSTEM)
    assert [step.action for step in found.steps] == [StateRequest("reset", "A0")]
    [finding] = found.skipped
    assert finding.code == "SYS0027"
    assert finding.severity is Severity.WARNING
    assert finding.message == f"{message}: the event is skipped"
    assert finding.hint == hint
    assert finding.span is not None
    assert finding.span.line == 3


def test_a_cut_of_two_ports_is_that_of_the_connection_at_that_time() -> None:
    text = (
        '[[at]]\nt = 1\nconnect = {from = "A0.out", to = "B0.in", name = "late"}\n'
        '[[at]]\nt = 2\ndisconnect = {from = "A0.out", to = "B0.in"}\n'
    )
    made, cut = parse(text, "t.toml", SYSTEM)
    assert made.action == Connect("late", A, B, {})
    assert cut.action == Disconnect("wire", ("late",))


def test_a_timeline_follows_another(tmp_path: Path) -> None:
    (tmp_path / "first.toml").write_text(
        '[[at]]\nt = 5\nconnect = { from = "A0.x", to = "B0.y", name = "more" }\n'
        '[[measure]]\nname = "one"\nkind = "moved"\nof = "A0.truth"\n'
    )
    (tmp_path / "deep").mkdir()
    (tmp_path / "deep" / "second.toml").write_text(
        'follows = "../first.toml"\n'
        '[[measure]]\nname = "two"\nkind = "moved"\nof = "B0.truth"\n'
        '[[at]]\nt = 4\ndisconnect = "wire"\n[[at]]\nt = 6\ndisconnect = "more"\n'
    )
    found = load(tmp_path / "deep" / "second.toml", SYSTEM)
    assert [step.action for step in found.steps] == [
        Disconnect("wire"),
        Connect("more", X, Y, {}),
        Disconnect("more"),
    ]
    assert [measure.name for measure in found.measures] == ["one", "two"]
    one, two = found.measures
    assert (one.span.line, two.span.line) == (4, 2)
    assert two.span.file.endswith("deep/second.toml")


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("follows = 3", 1),
        ("at = 3", 1),
        ("measure = [1]", 1),
        ('[[at]]\nt = 1\n[[measure]]\nname = "n"\nkind = "far"\nof = "A0.t"', 5),
        ('[[measure]]\nname = "n"\n[[at]]\nt = -1', 4),
    ],
)
def test_wrong_sections_have_their_place(text: str, line: int) -> None:
    assert findings(text)[0].span.line == line  # type: ignore[union-attr]


def test_a_timeline_that_cannot_be_read(tmp_path: Path) -> None:
    (tmp_path / "t.toml").write_text('follows = "missing.toml"\n')
    with pytest.raises(ToolError, match=r"missing\.toml"):
        load(tmp_path / "t.toml", SYSTEM)
