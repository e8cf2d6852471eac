"""Doc comments: at each place where one can stand, for IDL and CDL."""

from __future__ import annotations

from itertools import product
from pathlib import Path

import msgspec
import pytest

from rtgen import api

IDL = """\
{0}module m {{ {1}
  {2}struct S {{ {3}
    {4}long x{5}; {6}
    long y{7}; {8}
  }}; {9}
  enum E {{ {10}
    {11}A1{12}, {13}
    B1{14} {15}
  }}; {16}
  union U switch (long) {{ {17}
    {18}case 1: {19}long w{20}; {21}
  }}; {22}
  interface I {{ {23}
    void f({24}in long a{25}, {26}
      {27}in long b{28}); {29}
  }}; {30}
  const long C = 3{31}; {32}
  component Co {{ {33}
    publishes S p{34}; {35}
  }}; {36}
}};
"""
IDL_OWNERS = dict(
    enumerate(
        (
            *("", "m::S", "m::S", "x", "x", "x", "x", "y", "y", "m::S", "A1", "A1"),
            *("A1", "A1", "B1", "B1", "m::E", "w", "w", "w", "w", "w", "m::U", "f"),
            *("a", "a", "a", "b", "b", "f", "m::I", "m::C", "m::C", "p", "p", "p"),
            "m::Co",
        )
    )
)
CDL = """\
{0}signature sX {{ {1}
  {2}int32_t f({3}[in] int32_t a{4}, {5}
    {6}[in] int32_t b{7}); {8}
}}; {9}
{10}const int32_t N = 3{11}; {12}
typedef struct {{ {13}
  {14}int32_t x{15}; {16}
  int32_t y{17}; {18}
}} tS; {19}
"""
CDL_OWNERS = dict(
    enumerate(
        (
            *("sX", "f", "f", "a", "a", "a", "b", "b", "f", "sX", "N", "N", "N"),
            *("x", "x", "x", "x", "y", "y", "tS"),
        )
    )
)
BEHIND_NAMES = {
    "idl": {5, 7, 12, 14, 20, 25, 28, 31, 34},
    "cdl": {4, 7, 11, 15, 17},
}
"""Places between a name and the mark that ends its declaration."""
NEXT_LINE = {"idl": {6, 8, 13, 15}, "cdl": {16, 18}}
BLOCKS = ("/** text */", "/*! text */", "/** text\n   */")
LINES = ("/// text\n", "//! text\n")


def documented(text: str, suffix: str, folder: Path) -> dict[str, str]:
    """Return the doc comments of a text, by the names of the declarations."""
    file = folder / f"a.{suffix}"
    file.write_text(text)
    result = api.read(file)
    assert not [d for d in result.diagnostics if d.severity.name == "ERROR"]
    found: dict[str, str] = {}

    def walk(value: object) -> None:
        if isinstance(value, msgspec.Struct):
            name = getattr(value, "name", "")
            if doc := getattr(value, "doc", ""):
                found["::".join(name) if isinstance(name, tuple) else name] = doc
            for field in value.__struct_fields__:
                walk(getattr(value, field))
        elif isinstance(value, list | tuple):
            for each in value:
                walk(each)

    walk(result.model)
    return found


def with_comment(template: str, place: int, comment: str, number: int) -> str:
    return template.format(*(comment if n == place else "" for n in range(number)))


LANGUAGES = (("idl", IDL, IDL_OWNERS), ("cdl", CDL, CDL_OWNERS))
PLACES = [
    (suffix, template, place, owner, len(owners))
    for suffix, template, owners in LANGUAGES
    for place, owner in owners.items()
]


@pytest.mark.sampled(12)
@pytest.mark.parametrize(
    ("suffix", "template", "place", "owner", "number"),
    PLACES,
    ids=[f"{suffix}-{place}" for suffix, _, place, _, _ in PLACES],
)
def test_a_comment_belongs_to_one_declaration(
    suffix: str, template: str, place: int, owner: str, number: int, tmp_path: Path
) -> None:
    comments = [*BLOCKS]
    if place not in BEHIND_NAMES[suffix]:
        # A comment of a line ends it, so it can only stand in front of another one.
        comments += LINES
    for comment in comments:
        found = documented(
            with_comment(template, place, comment, number), suffix, tmp_path
        )
        assert found == ({owner: "text"} if owner else {}), comment


@pytest.mark.parametrize("suffix", ["idl", "cdl"])
@pytest.mark.parametrize(
    "comment", ["/* text */", "// text", "///< text", "/**< text */"]
)
def test_comments_at_the_end_of_a_line(
    suffix: str, comment: str, tmp_path: Path
) -> None:
    [(template, owners)] = [(t, o) for s, t, o in LANGUAGES if s == suffix]
    for place in NEXT_LINE[suffix]:
        text = with_comment(template, place, comment, len(owners))
        assert documented(text, suffix, tmp_path) == {owners[place]: "text"}


@pytest.mark.parametrize("kind", ["/** {} */", "/*! {} */"])
def test_several_declarations_on_a_line(kind: str, tmp_path: Path) -> None:
    members = [f"{kind.format(name)} long {name};" for name in "abc"]
    for between, close in product((" ", "\n"), (" ", "\n")):
        text = f"struct S {{ {between.join(members)}{close}}};"
        found = documented(text, "idl", tmp_path)
        assert found == {name: name for name in "abc"}


@pytest.mark.parametrize(
    "comment", ["/* text */", "// text\n", "/**/", "/** rtgen: ignore[LINT0003] */"]
)
def test_other_comments_in_front_are_no_documentation(
    comment: str, tmp_path: Path
) -> None:
    assert documented(f"struct S {{ {comment} long x; }};", "idl", tmp_path) == {}
