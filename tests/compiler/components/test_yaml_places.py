"""Positions of diagnostics about profiles in YAML."""

from __future__ import annotations

import pytest
import yaml

from rtgen.compiler.diagnostics import Diagnostic, InputError
from rtgen.compiler.frontends.kit import located_yaml
from rtgen.compiler.frontends.kit.located_yaml import YamlError
from rtgen.compiler.frontends.profiles import profile_tree, profile_yaml, rts_profile

SYSTEM = """\
rtsProfile:
  id: RTSystem:Sample:pair:1.0
  version: "0.2"
  components:
    - instanceName: Pump0
      id: RTC:Sample:Fluid:Pump:1.0
    - instanceName: Pump0
      id: RTC:Sample:Fluid:Pump:1.0
      executionContexts:
        - rate: fast
    - id: RTC:Sample:Fluid:Valve:1.0
"""


@pytest.fixture(autouse=True, params=["libyaml", "Python"])
def parser(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Read by libyaml, and as where PyYAML has no libyaml."""
    if request.param == "Python":
        monkeypatch.setattr(yaml, "__with_libyaml__", False)
    elif not yaml.__with_libyaml__:
        pytest.skip("PyYAML has no libyaml")


def places(diagnostics: tuple[Diagnostic, ...]) -> list[tuple[str, int, int, int]]:
    return [
        (d.code, d.span.line, d.span.column, d.span.end_column)
        for d in diagnostics
        if d.span is not None
    ]


def test_a_system() -> None:
    result = rts_profile.load_bytes(SYSTEM.encode(), "pair.yaml")
    assert result.sources == {"pair.yaml": SYSTEM}
    assert places(result.diagnostics) == [
        ("RTC0512", 7, 21, 26),
        ("RTC0511", 11, 7, 8),
    ]
    [related] = result.diagnostics[0].related
    assert (related.span.line, related.span.column) == (5, 21)


@pytest.mark.parametrize(
    ("text", "place", "message"),
    [
        ("rtsProfile: {a b: c}", (1, 14), "'a b' is not a key of a profile"),
        ("rtsProfile: {no::a: c}", (1, 14), "'no::a' is not a key of a profile"),
        ("rtsProfile: {id: x,\n rts::id: y}", (2, 2), "`id` is given twice"),
        ('rtsProfile: {id: "\\0"}', (1, 18), "`id` has a character that XML cannot"),
        ('rtsProfile: {id: "\\ud800"}', (1, 18), "`id` has a character"),
        (
            "rtsProfile:\n  components: [[a]]",
            (2, 16),
            "`Components` may occur only once",
        ),
        (
            "rtsProfile:\n  creationDate: {year: soon}",
            (2, 17),
            "a date must consist of numbers",
        ),
        ("- a", (1, 1), "there is neither `rtcProfile` nor `rtsProfile`"),
        ("", (1, 1), "there is neither `rtcProfile` nor `rtsProfile`"),
        ("a: &x b\nc: *x", (2, 4), "an alias"),
        ("? [a]\n: b", (1, 3), "not YAML: a key that is not text"),
        ("a: b\n--- c", (2, 1), "not YAML: expected a single document"),
        ("a: [b", (1, 6), "not YAML: expected ',' or ']', but got '<stream end>'"),
    ],
)
def test_what_is_no_profile(text: str, place: tuple[int, int], message: str) -> None:
    with pytest.raises(InputError) as raised:
        profile_yaml.parse(text, "a.yaml")
    [found] = raised.value.diagnostics
    assert found.code == "RTC0545"
    assert found.span is not None
    assert (found.span.line, found.span.column) == place
    assert found.message.startswith(message)


def test_the_tree_is_that_of_the_xml() -> None:
    findings = profile_tree.sink()
    direct, _ = profile_tree.parse(SYSTEM.encode(), "a.yaml", findings.report)
    xml = profile_yaml.to_xml(SYSTEM, "a.yaml")
    printed, _ = profile_tree.parse(xml.encode(), "a.xml", findings.report)
    assert direct is not None
    assert printed is not None
    assert findings.diagnostics == ()
    assert profile_yaml.to_yaml(direct) == profile_yaml.to_yaml(printed)


def test_findings_are_bounded() -> None:
    components = "    - {}\n" * 1200
    text = f"rtsProfile:\n  components:\n{components}"
    result = rts_profile.load_bytes(text.encode(), "a.yaml")
    assert [d.code for d in result.diagnostics] == ["RTC0511"] * 1000 + ["RTC0506"]
    assert result.system is None


def test_places_of_lists_texts_and_mappings() -> None:
    root = located_yaml.parse("a:\n  - 12\n  - 'b c'\n", "a.yaml")
    assert isinstance(root.content, dict)
    [items] = root.content.values()
    assert (items.key.line, items.key.column, items.key.end_column) == (1, 1, 2)
    assert [
        (i.content, i.span.line, i.span.column, i.span.end_column)
        for i in items.content
        if isinstance(i, located_yaml.Node)
    ] == [("12", 2, 5, 7), ("b c", 3, 5, 10)]


def test_the_end_of_a_mapping_in_one_line() -> None:
    for text, end in (("a: {b: c}", 10), ("a:\n  b: c\n", 4)):
        content = located_yaml.parse(text, "a.yaml").content
        assert isinstance(content, dict)
        assert content["a"].span.end_column == end


def test_a_long_text() -> None:
    with pytest.raises(YamlError, match="longer than 1,048,576 characters"):
        located_yaml.parse("a" * (1 << 20) + "b", "a.yaml")
