"""Small types and embedded ones write the same octets, and refuse what exceeds the capacity."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from micropython import micropython

from rtgen.cli import run

INPUT = (
    Path(__file__).parents[2] / "golden" / "cases" / "RTC0600_target_small" / "input"
)

EMBEDDED = """
from random import Random
from robots import m

chance = Random(7)

def text(most):
    made = "".join(chance.choice("ab\u00e9\u3042") for _ in range(most))
    while len(made.encode()) > chance.randint(0, most):
        made = made[:-1]
    return made

def item():
    state = m.Mode(chance.randint(0, 1))
    return m.Item(state, chance.randbytes(4), m.Point(chance.random(), -chance.random()))

def some(make, most):
    return [make() for _ in range(chance.randint(0, most))]

def level():
    return chance.choice(list(m.Level))

def truth():
    return chance.random() < 0.5

print(m.All().to_cdr(little_endian=True).hex())
for _ in range(200):
    value = m.All(
        flag=truth(),
        letter=chr(chance.randint(0, 255)),
        small_=chance.randint(-32768, 32767),
        large=chance.randint(0, 2**32 - 1),
        most=chance.randint(-(2**63), 2**63 - 1),
        single=chance.randint(-1000, 1000) / 8,
        name=text(20),
        code=text(5),
        data=chance.randbytes(chance.randint(0, 16)),
        values=some(lambda: chance.randint(-9, 9) / 4, 4),
        items=some(item, 2),
        names=some(lambda: text(3), 2),
        pair=[chance.random(), chance.random()],
        flags=[truth(), truth(), truth()],
        corners=[m.Point(1.0, chance.random()), m.Point(chance.random(), 2.0)],
        choices=some(truth, 16),
        modes=some(lambda: m.Mode(chance.randint(0, 1)), 16),
        step=level(),
        ends=[level(), level()],
        levels=some(level, 4),
    )
    print(value.to_cdr(little_endian=True).hex())
"""

SMALL = """
from rtgen.runtime import CodecError, SizeError, from_cdr, to_cdr
from robots import m

buffer = bytearray(2048)
fresh = bytes(buffer[: to_cdr(m.All(), buffer)]).hex()
value, copied = m.All(), m.All()
for place, line in enumerate(open("given.txt")):
    if place == 0 and line.strip() != fresh:
        raise AssertionError(fresh)
    octets = bytes.fromhex(line.strip())
    buffer[: len(octets)] = octets
    from_cdr(value, buffer, len(octets))
    copied._copy_(value)
    print(bytes(buffer[: to_cdr(copied, buffer)]).hex())
    for length in range(0, len(octets), 7):
        buffer[: len(octets)] = octets
        try:
            from_cdr(value, buffer, length)
        except CodecError:
            continue
        raise AssertionError(length)
for change in (
    {"name": "x" * 21},
    {"data": bytes(17)},
    {"values": [0.0] * 5},
    {"pair": [1.0]},
    {"names": ["abcd"]},
):
    try:
        to_cdr(m.All(**change), buffer)
    except SizeError:
        continue
    raise AssertionError(change)
"""


DEFAULTS = """
module M {
    enum Mode { IDLE, @default_literal BUSY, @value(9) LAST };
    @default(7) typedef long Seven;
    @default("1, 2") typedef sequence<short> Two;
    struct Point { @default(1.0) double x; @default(-2.5) double y; };
    struct All {
        @default(TRUE) boolean flag; @default('c') char letter; Seven usual; Mode now;
        @default(LAST) Mode last; @default("a\\"b") string name; @default("inf") float far[1];
        @default("1, 2") octet id[2]; @default("3") sequence<octet> data; Two some;
        @default("x, 'y, z'") sequence<string<9>, 3> names; Seven sevens[2]; Mode modes[2];
        @default("0.5, -1") double pair[2]; @default("LAST, IDLE") sequence<Mode> listed;
        @default("true, false, true") boolean flags[3]; Point place; Point corners[2];
        sequence<Point> none;
    };
};
@rtc(category="C", vendor="v", version="1.0.0")
component Board { publishes M::All done; };
"""


def generated_from(folder: Path) -> Path:
    """Return the folder generated for both runtimes from the definitions in a folder."""
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        code = run(
            ["generate", "board.idl", "--target", "small", "--no-cache", "--quiet"]
        )
    assert code == 0
    return folder / "generated"


@pytest.fixture(scope="module")
def generated(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("small")
    for file in INPUT.iterdir():
        (folder / file.name).write_bytes(file.read_bytes())
    return generated_from(folder)


def printed(code: str, folder: Path, given: str = "") -> str:
    (folder / "given.txt").write_text(given)
    result = subprocess.run(
        [sys.executable, "-c", code],
        env={**os.environ, "PYTHONPATH": str(folder)},
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
    )
    assert result.returncode == 0, result.stderr
    return result.stdout


def test_octets_are_those_of_the_embedded_types(generated: Path) -> None:
    octets = printed(EMBEDDED, generated)
    assert len(octets.splitlines()) == 201
    assert printed(SMALL, generated / "small", octets) == octets
    assert micropython(SMALL, generated / "small", octets) == octets


def test_members_start_with_their_defaults(tmp_path: Path) -> None:
    (tmp_path / "rtgen.toml").write_text('[output]\npackage = "robots"\n')
    (tmp_path / "board.idl").write_text(DEFAULTS)
    folder = generated_from(tmp_path)
    embedded = "from robots import m; print(m.All().to_cdr(True).hex())"
    small = """
from rtgen.runtime import to_cdr
from robots import m
buffer = bytearray(2048)
one, other = m.All(), m.All()
one.some.append(3)
one.corners[0].x = 0.0
print(bytes(buffer[: to_cdr(other, buffer)]).hex())
assert list(m.All(some=[4], pair=(1.0, 2.0)).some) == [4]
"""
    octets = printed(embedded, folder)
    assert len(octets) > 300
    assert printed(small, folder / "small") == octets
    assert micropython(small, folder / "small") == octets
