"""Doors for definition files: IDL, CDL, C headers, EDS, DCF, ROS 2 interfaces, modules to adopt."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import partial
from pathlib import Path
from random import Random

from cdl import CdlTarget
from eds import EdsTarget
from fuzzing import Target, ViolationError, log_uniform
from idl_grammar import program
from idl_mutations import mutant
from idl_target import IdlTarget
from idl_words import LINES, NAMES, NUMBERS, TEXTS

from doors import Door, variant
from doors.mixing import files, mixing
from rtgen.compiler.diagnostics import Diagnostic, has_errors
from rtgen.compiler.diagnostics.explain import rules
from rtgen.compiler.diagnostics.report import report
from rtgen.compiler.frontends import cdl
from rtgen.compiler.inspection.models import inspect
from rtgen.facts.ros import GENERATED_IDL
from rtgen.openrtm import python_modules
from rtgen.ros2 import rosidl

REFUSED = ("rejected", "errors", "no system")
"""The labels of targets that stand for a refusal."""


def known(found: Iterable[Diagnostic]) -> bool:
    """Return whether there are no errors. Raises ViolationError for an unknown rule."""
    found = tuple(found)
    for each in found:
        if each.code not in rules() or each.span is None:
            raise ViolationError(f"{each.code} without a rule or a place")
    return not has_errors(found)


def of_target(
    target: Target,
    make: Callable[[Random], bytes] | None = None,
    way: int | None = None,
) -> Door:
    """Return the door of a target; `way` is its number, by default taken from the octets."""

    def enter(data: bytes) -> bool:
        number = variant(data) if way is None else way
        return not set(REFUSED).intersection(target.check(number, data))

    return Door(enter, make or (lambda chance: target.make(chance.getrandbits(32))))


def _idl(folder: Path) -> Door:
    def make(chance: Random) -> bytes:
        return chance.choice((program, mutant))(chance.getrandbits(32))

    return of_target(IdlTarget(folder, mutant), make)


def _preprocessor(folder: Path) -> Door:
    """Return the door for directives: lines of them, hardly interrupted by IDL."""
    words = [word.encode() for word in (*LINES, *NAMES, *NUMBERS, *TEXTS)]
    words += [
        b"(a,b) a##b #a",
        b"defined(A)",
        b"&&",
        b"?:",
        b"#endif",
        b"#else",
        b"A(",
        b")",
    ]

    def make(chance: Random) -> bytes:
        count = log_uniform(1, 60, chance.random())
        parts = (
            chance.choice(words) + chance.choice((b"\n", b"\n", b" ", b"\\\n"))
            for _ in range(count)
        )
        return b"".join(parts)

    return of_target(IdlTarget(folder, mutant), make)


def _cdl(folder: Path) -> Door:
    return of_target(CdlTarget(folder))


def _c_header(folder: Path) -> Door:
    unit, header = folder / "input.cdl", folder / "input.h"
    unit.write_text('import_C("input.h");\nsignature sS { ER f([in] int32_t a); };\n')

    def enter(data: bytes) -> bool:
        header.write_bytes(data)
        result = cdl.load([unit], root=folder)
        report(result.diagnostics, result.sources)
        return known(result.diagnostics)

    seeds = files("tests/**/*.h", "specs/**/*.h")
    return Door(enter, mixing(seeds), seeds)


def _described(suffix: str, folder: Path) -> Door:
    way = {"eds": 1, "dcf": 6}[suffix]
    return of_target(EdsTarget(folder), way=way)


_INPUT_IDL = b"""
#include "std_msgs/msg/Header.idl"
module fuzzed_msgs { module msg {
    typedef double double__2[2];
    module Input_Constants {
        @verbatim (language="comment", text="a" "\\n") const string X = "a\\"b";
    };
    struct Input {
        @default (value="(1, -2)") sequence<int16, 3> a;
        @unit (value="m") double__2 b;
        std_msgs::msg::Header c;
        @default (value="('a', 'b')") sequence<string<5>> d;
    };
}; };
"""


def _msg(folder: Path) -> Door:
    package = folder / "fuzzed_msgs"
    paths = [package / kind / f"Input.{kind}" for kind in ("msg", "srv", "action")]
    for path in paths:
        path.parent.mkdir(parents=True)
    generated = package / "msg" / "Input.idl"

    def enter(data: bytes) -> bool:
        path = paths[data.count(b"---") % 3]
        if data.startswith(GENERATED_IDL):
            path = generated
        path.write_bytes(data)
        result = rosidl.load([path], root=folder)
        report(result.diagnostics, result.sources)
        inspect(result.model, result.diagnostics)
        return known(result.diagnostics)

    seeds = files("tests/**/*.msg", "tests/**/*.srv", "tests/**/*.action")
    seeds += [
        b"int32 a 3\nstring<=5[<=3] b\nuint8 X=1\nstd_msgs/Header h\n---\nbool ok\n",
        GENERATED_IDL + _INPUT_IDL,
    ]
    return Door(enter, mixing(seeds), seeds)


def _adopt(folder: Path) -> Door:
    path = folder / "Input.py"

    def enter(data: bytes) -> bool:
        path.write_bytes(data)
        result = python_modules.read(path, [folder])
        report(result.diagnostics, result.sources)
        accepted = known(result.diagnostics)
        if accepted and result.profile is None:
            raise ViolationError("neither a profile nor an error")
        return accepted

    seeds = files(
        "tests/golden/cases/openrtm_module/expected/**/Relay.py",
        "tests/openrtm/modules/*.py",
    )
    return Door(enter, mixing(seeds), seeds)


DOORS: dict[str, Callable[[Path], Door]] = {
    "idl": _idl,
    "preprocessor": _preprocessor,
    "cdl": _cdl,
    "c-header": _c_header,
    "eds": partial(_described, "eds"),
    "dcf": partial(_described, "dcf"),
    "msg": _msg,
    "adopt": _adopt,
}
