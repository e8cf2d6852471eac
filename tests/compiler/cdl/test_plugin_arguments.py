"""The argument of rtgen's plug-in: names and values with their positions."""

from __future__ import annotations

import pytest

from rtgen.compiler.diagnostics import Severity, Span
from rtgen.compiler.frontends.cdl.pipeline import read_text
from rtgen.compiler.model.tecs import PluginOption, Through

HEAD = """signature sWork { void work( void ); };
celltype tWorker { entry sWork eWork; };
[active] celltype tUser { call sWork cWork; };
cell tWorker Worker {};
"""


def user(plugin: str, argument: str) -> str:
    """Return a cell with that plug-in on its join."""
    return f"cell tUser User {{ [through( {plugin}, {argument} )] cWork = Worker.eWork; }};\n"


def through(argument: str, plugin: str = "RTCPlugin") -> tuple[Through, list[str]]:
    """Return the plug-in of a join for an argument (with its quotes), and codes of findings."""
    unit, found = read_text(HEAD + user(plugin, argument))
    ((_, join),) = unit.joins_through("RTCPlugin")
    return join.through[0], [d.code for d in found if d.severity is not Severity.NOTE]


def values(argument: str) -> dict[str, str]:
    """Return the options of an argument without errors."""
    made, codes = through(argument)
    assert codes == []
    return {option.name: option.value for option in made.options}


@pytest.mark.parametrize(
    ("argument", "expected"),
    [
        ('""', {}),
        ('"   "', {}),
        ('"port=8931"', {"port": "8931"}),
        ('" port = 8931 , "', {"port": "8931"}),
        ('"a=b c ,d="', {"a": "b c", "d": ""}),
        (r'"a=\"b, c\", d=1"', {"a": "b, c", "d": "1"}),
        ("\"a='b, c' , d=%e, f%, g=!h!\"", {"a": "b, c", "d": "e, f", "g": "h"}),
        (r'"a=b\,c"', {"a": "b,c"}),
        (r'"a=b\\c, d=\%"', {"a": r"b\c", "d": "%"}),
        ('"por" "t=89" "31"', {"port": "8931"}),
        ('"a=1,"\n   /* why */ "b=2"', {"a": "1", "b": "2"}),
        (
            '"a=$source$_$destination$, b=$count$, c=$$"',
            {"a": "User_Worker", "b": "0", "c": "$"},
        ),
        ('"a=$SOURCE$.$NEXT$, b=!$start_region$!"', {"a": "User.Worker", "b": ""}),
        ('"a=1,\\\n b=2"', {"a": "1", "b": "2"}),
    ],
)
def test_values(argument: str, expected: dict[str, str]) -> None:
    assert values(argument) == expected


@pytest.mark.parametrize(
    ("argument", "message"),
    [
        ('"8931"', "a name is missing here"),
        ('"a=1,,b=2"', "a name is missing here"),
        ('"a"', "= is missing after a"),
        ('"a b=1"', "= is missing after a"),
        ('"a=\'b"', "the value of a is never closed"),
        ("\"a='b'c, d=1\"", "there is text after the value of a"),
    ],
)
def test_mistakes(argument: str, message: str) -> None:
    _, found = read_text(HEAD + user("RTCPlugin", argument))
    assert [(d.code, d.message) for d in found] == [("CDL0713", message)]


def test_the_last_value_counts() -> None:
    made, codes = through('"a=1, a=2"')
    assert codes == ["CDL0714"]
    assert [option.value for option in made.options] == ["2"]


def test_unknown_substitution() -> None:
    made, codes = through('"a=$what$"')
    assert codes == ["CDL0715"]
    assert made.options[0].value == "$what$"


@pytest.mark.parametrize("plugin", ["RTCPlugin", "RTCPlug-in", "rTCPlugin"])
def test_names(plugin: str) -> None:
    made, codes = through('"a=1"', plugin)
    assert (made.plugin, codes) == ("RTCPlugin", [])


def test_places() -> None:
    """Each name and value has its position in the source, over several literals and lines."""
    text = HEAD + (
        "cell tUser User {\n"
        '  [through( RTCPlugin, "port=8931, "\n'
        '     "name = \\"a\\", timeout=2" )] cWork = Worker.eWork;\n'
        "};\n"
    )
    unit, _ = read_text(text, "a.cdl")
    ((_, join),) = unit.joins_through("RTCPlugin")
    lines = text.split("\n")

    def shown(span: Span) -> str:
        assert span.line == span.end_line
        return lines[span.line - 1][span.column - 1 : span.end_column - 1]

    def pair(option: PluginOption) -> tuple[str, str]:
        return shown(option.span), shown(option.value_span)

    assert [*map(pair, join.through[0].options)] == [
        ("port", "8931"),
        ("name", "a"),
        ("timeout", "2"),
    ]


def test_foreign_plugins_keep_their_arguments() -> None:
    unit, found = read_text(HEAD + user("TracePlugin", '"8931 ="'))
    assert found == ()
    ((_, join),) = unit.joins_through("TracePlugin")
    assert join.through[0].argument.text == "8931 ="
    assert join.through[0].options == ()


def test_regions_chain_in_order_from_the_caller() -> None:
    text = HEAD + """
[out_through( TracePlugin, "one" ), to_through( rB, RTCPlugin, "a=$start_region$" )]
region rA {
  [out_through( TracePlugin, "two" )] region rIn {
    cell tUser Deep { [through( RTCPlugin, "" ), through( TracePlugin, "join" )]
      cWork = rB::rIn::Far.eWork; };
  };
};
[in_through( TracePlugin, "not used behind to_through" )]
region rB {
  [in_through( TracePlugin, "three" ), in_through( TracePlugin, "four" )]
  region rIn { cell tWorker Far {}; };
};
"""
    unit, found = read_text(text)
    assert [d.code for d in found] == ["CDL0608"]  # Worker is not called here
    (join,) = (j for c, j in unit.joins_through("RTCPlugin") if c.name[-1] == "Deep")
    assert [(t.plugin, t.argument.text, t.origin, t.region) for t in join.through] == [
        ("RTCPlugin", "", "through", ()),
        ("TracePlugin", "join", "through", ()),
        ("TracePlugin", "two", "out_through", ("rA", "rIn")),
        ("RTCPlugin", "a=$start_region$", "to_through", ("rA",)),
        ("TracePlugin", "three", "in_through", ("rB", "rIn")),
        ("TracePlugin", "four", "in_through", ("rB", "rIn")),
    ]
    assert join.through[3].options[0].value == "rA::rIn"
