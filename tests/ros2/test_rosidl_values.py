"""Interface files read as by rosidl itself: random lines, refused by both, or with equal values."""

from __future__ import annotations

import json
import math
import random
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from ros2_peers import DISTRIBUTIONS, Installation, installation
from seeds import cases

from rtgen.compiler.diagnostics import Severity
from rtgen.compiler.model import Const, Struct
from rtgen.ros2.rosidl import load

pytestmark = pytest.mark.peer

ORACLE = Path(__file__).with_name("rosidl_oracle.py")
INTEGERS = tuple(f"{u}int{n}" for u in ("", "u") for n in (8, 16, 32, 64))
NUMBERS = (*INTEGERS, "byte", "char", "bool", "float32", "float64")
TEXTS = ("string", "wstring", "string<=5", "wstring<=3")
PIECES = (
    *(
        "a",
        "b",
        "Z",
        "0",
        "7",
        " ",
        "  ",
        "\t",
        ",",
        "]",
        "[",
        "#",
        "=",
        "@",
        "é",
        "表",
    ),
    *("\\", "\\\\", '"', "'", '\\"', "\\'", "\\n", "\\t", "\\a", "\\r", "\\d", "\\?"),
    *("\\x41", "\\x4", "\\xe9", "\\u0041", "\\u8868", "\\U00000041", "\\101", "\\7"),
    *("\\303\\251", "\\N{DIGIT ONE}", "\\N{NO}", "\\x22", "\\x27", "\\x5c", "//", "/*"),
)
LITERALS = (
    *("0", "1", "-1", "+2", "012", "0x1F", "0X1f", "0b1", "0o17", "1e3", "1.5", ".5"),
    *("127", "128", "255", "256", "-128", "-129", "65535", "4294967296", "1_000", "_1"),
    *("9223372036854775807", "-9223372036854775808", "18446744073709551615", "5."),
    *(
        "true",
        "True",
        "FALSE",
        "yes",
        "",
        "--1",
        "1 2",
        "0x",
        "-0x10",
        "1_0.5",
        "1e400",
    ),
    *("- 1", "\uff15", "0.1e-5", "-0.0", "1L", "1f", "3.14159265358979", "1E+2"),
)

SMALL = ("0", "1", "+2", "127", "1_0", "0x1F", "0b1", "0o17", "012")
"""Integers that each type of numbers has, in forms that not all readers take."""
GAPS = (" ", " ", "  ", "\t")
EQUALS = ("=", " = ", "= ")


def number(drawn: random.Random) -> str:
    if drawn.random() < 0.7:
        return drawn.choice(LITERALS)
    return "".join(drawn.choices("0123456789-+.exX_ab ", k=drawn.randint(1, 5)))


def text(drawn: random.Random) -> str:
    inner = "".join(drawn.choices(PIECES, k=drawn.randint(0, 5)))
    quote = drawn.choice(("", '"', "'", '"'))
    return f"{quote}{inner}{quote if drawn.random() < 0.95 else ''}"


def elements(drawn: random.Random, one: Callable[[random.Random], str]) -> str:
    made = [one(drawn) for _ in range(drawn.choice((0, 1, 2, 2, 3)))]
    inner = drawn.choice((",", ", ", " ,", ",,")).join(made)
    return drawn.choice(
        (f"[{inner}]", f"[{inner}]", f"[{inner} ]", f"[{inner},]", inner)
    )


def line(drawn: random.Random) -> str:
    """Return a line that is often a field with a default or a constant."""
    if drawn.random() < 0.3:
        return likely_line(drawn)
    is_text = drawn.random() < 0.5
    type_ = drawn.choice(TEXTS if is_text else NUMBERS)
    value: Callable[[random.Random], str] = text if is_text else number
    gap = drawn.choice(GAPS)
    if drawn.random() < 0.4:
        name = drawn.choice(("A", "A1", "A_B", "A__B", "a", "A_", "1A"))
        return f"{type_}{gap}{name}{drawn.choice((*EQUALS, '=='))}{value(drawn)}"
    array = drawn.choice(("", "", "[]", "[2]", "[<=2]", "[+2]", "[0]", "[<=]", "[02]"))
    name = drawn.choice(("a", "a1", "a_b", "a__b", "A", "a_", "_a"))
    if drawn.random() < 0.1:
        return f"{type_}{array}{gap}{name}"
    made = elements(drawn, value) if array and drawn.random() < 0.9 else value(drawn)
    return f"{type_}{array}{gap}{name}{gap}{made}"


def likely_line(drawn: random.Random) -> str:
    """Return a line without the frequent mistakes: names, bounds of arrays, ranges, quotes."""
    is_text = drawn.random() < 0.5
    type_ = drawn.choice(("string", "wstring") if is_text else NUMBERS)
    gap = drawn.choice(GAPS)
    literals = SMALL if type_ != "bool" else ("true", "false", "0", "1", "False")
    if "float" in type_:
        literals = (*SMALL, "1e3", "1.5", ".5", "-0.1e-5", "5.", "1_0.5")

    def value() -> str:
        if not is_text:
            return drawn.choice(literals)
        quote = drawn.choice("\"'")
        pieces = [each for each in PIECES if quote not in each]
        return quote + "".join(drawn.choices(pieces, k=drawn.randint(0, 4))) + quote

    if drawn.random() < 0.4:
        name = drawn.choice(("A", "A1", "A_B"))
        return f"{type_}{gap}{name}{drawn.choice(EQUALS)}{value()}"
    array = drawn.choice(("", "", "[]", "[2]", "[<=2]"))
    field = f"{type_}{array}{gap}{drawn.choice(('a', 'a1', 'a_b'))}{gap}"
    if not array:
        return f"{field}{value()}"
    count = 2 if array == "[2]" else drawn.randint(0, 2)
    made = [value() for _ in range(count)]
    return f"{field}[{drawn.choice((',', ', ', ' ,')).join(made)}]"


def own(folder: Path, content: str) -> dict[str, Any] | None:
    """Return constants, defaults and fields as rtgen reads them; None for a refused text."""
    path = folder / "lab" / "msg" / "Drawn.msg"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(content, encoding="utf-8", newline="")
    result = load([path], root=folder)
    if any(each.severity is Severity.ERROR for each in result.diagnostics):
        return None
    message = result.model.find(("lab", "msg", "Drawn"))
    assert isinstance(message, Struct)
    constants = (d for d in result.model.declarations if isinstance(d, Const))
    defaults = {m.name: m.initial for m in message.members if m.initial is not None}
    return {
        "constants": {each.name[-1]: each.value for each in constants},
        "defaults": {
            name: [*value] if isinstance(value, tuple) else value
            for name, value in defaults.items()
        },
        "fields": [member.name for member in message.members],
    }


def is_equal(one: Any, other: Any) -> bool:
    """Return whether values are equal; rosidl_parser reads `nan` and `inf` as names."""
    if isinstance(one, dict):
        return one.keys() == other.keys() and all(
            is_equal(one[key], other[key]) for key in one
        )
    if isinstance(one, float) and not math.isfinite(one):
        return isinstance(other, str) and other.strip("+-").lower() in ("nan", "inf")
    return type(one) is type(other) and bool(one == other)


def is_left_out(content: str, theirs: Any) -> bool:
    """Return whether rtgen is meant to differ: no float32 holds the number."""
    numbers = [*theirs["constants"].values(), *theirs["defaults"].values()]
    flat = [n for each in numbers for n in (each if isinstance(each, list) else [each])]
    return "float32" in content and any(
        isinstance(n, float) and abs(n) > 3.5e38 for n in flat
    )


@pytest.mark.sampled(1)
@pytest.mark.parametrize("distribution", DISTRIBUTIONS)
def test_lines(distribution: str, tmp_path: Path) -> None:
    ros2: Installation = installation(distribution)
    drawn = [line(random.Random(n)) for n in cases(250)]
    # rosidl_adapter replaces escapes in comments, too.
    texts = [each for each in drawn if "\\" not in each.partition("#")[2]]
    process = subprocess.run(
        [ros2.python, str(ORACLE)],
        env=ros2.environment(),
        input="".join(f"{json.dumps(each)}\n" for each in texts),
        stdout=subprocess.PIPE,
        text=True,
        check=True,
    )
    answers = [json.loads(each) for each in process.stdout.splitlines()]
    accepted = 0
    for content, theirs in zip(texts, answers, strict=True):
        found = own(tmp_path, content)
        if found is None or theirs is None:
            if theirs is not None and is_left_out(content, theirs):
                continue
            assert found is theirs is None, (content, found, theirs)
            continue
        accepted += 1
        for part in ("constants", "defaults", "fields"):
            assert is_equal(found[part], theirs[part]), (content, found, theirs)
    # The comparison is of both kinds of lines.
    assert len(texts) // 10 < accepted < len(texts) * 9 // 10
