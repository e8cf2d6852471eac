"""The IDL front end with any input: coded findings in bounded time."""

import os
import time
from collections.abc import Iterable
from contextlib import suppress
from functools import partial
from pathlib import Path

import pytest
from fuzzing import Report, TimeUp, ViolationError, Watch, attempt, run
from generated import Generated, generate
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from idl_grammar import is_valid, program
from idl_mutations import mutant
from idl_target import IdlTarget, findings, has_marker
from idl_words import (
    ANNOTATIONS,
    CONTEXTUAL,
    KEYWORDS,
    LINES,
    MARKS,
    NAMES,
    NUMBERS,
    TEXTS,
)
from octets import VERSIONS, OctetsTarget
from seeds import budget, cases

from rtgen.compiler.diagnostics import Severity, Span, has_errors
from rtgen.compiler.frontends import FrontendResult
from rtgen.compiler.frontends.idl import load
from rtgen.compiler.frontends.idl.rules import syntax

PIECES = [
    *(*KEYWORDS, *CONTEXTUAL, *MARKS, *NAMES, *NUMBERS, *TEXTS, *ANNOTATIONS),
    *(f"\n{line}\n" for line in LINES),
]
BOUNDED = settings(
    max_examples=budget(120),
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)
FOUND: dict[str, tuple[str, tuple[str, ...]]] = {
    "typedef_of_itself_in_a_misplaced_module": (
        "const long t = 1; module t { module E { interface x; };"
        " module E { typedef x M, x; struct S { ::t::E::x a; }; }; };",
        ("IDL0202", "IDL0202", "IDL0209"),
    ),
    "annotation_of_native": ("@key native N;", ("IDL0801",)),
    "annotation_of_box": ("@nested valuetype V long;", ("IDL0801",)),
    "absolute_name_behind_annotation": (
        "struct T { long a; }; struct S { @external ::T a; };",
        (),
    ),
    "word_of_components_behind_annotation": (
        '@topic(name="x") struct map { long a; }; struct S { @unit("m") map a; };',
        (),
    ),
    "type_called_manages": (
        "struct manages { long a; }; typedef manages T;",
        ("IDL0208",),
    ),
    "base_declared_in_place": (
        "typedef struct A { long x; } B; struct C : B { long y; };",
        (),
    ),
    "nearly_map": ("struct S { mapp<long, long> a; long b; };", ("IDL0102",)),
    "vector_behind_an_annotation": (
        "struct S { @id(1)\n vector<long> a; };",
        ("IDL0121",),
    ),
    "constant_called_final": (
        "const wchar Final = L'.'; @extensibility(FINAL) struct S { long a; };",
        (),
    ),
    "typedef_called_like_what_it_names": (
        "interface I; typedef sequence<I> I; interface I { I f(); };",
        ("IDL0202",),
    ),
    "type_called_finder": (
        "interface finder {}; valuetype V { finder f(out long a); };",
        ("IDL0208",),
    ),
    "call_that_is_open_on_line_0": (
        "#define A(x) x\n#line 0\n  A(\n",
        ("IDL0018",),
    ),
    "forward_in_a_redeclared_interface": (
        "interface N { struct D; }; interface N { struct D { long a; }; D f(); };",
        ("IDL0215", "IDL0202"),
    ),
    "use_of_a_forward_in_a_redeclared_interface": (
        "interface N { struct D { long a; }; }; interface N { struct D; D f(); };",
        ("IDL0202", "IDL0215"),
    ),
    "lone_underscore": ("enum E { _, A }; struct S { long __; };", ("IDL0207",) * 2),
    "id_that_follows_is_taken": (
        "struct S { @id(2) long a; @id(1) long b; long c; };",
        ("IDL0804",),
    ),
    "id_of_more_than_28_bits": (
        "union U switch (long) { case 1: @id(0x10000000) long a; };",
        ("IDL0802",),
    ),
}
"""Defects that fuzzing found, minimized, with the right codes."""


def read(folder: Path, data: bytes) -> FrontendResult:
    path = folder / "input.idl"
    path.write_bytes(data)
    result = load([path], root=folder)
    findings(result.diagnostics, result.sources, moved=has_marker(data))
    return result


@pytest.mark.nightly
@pytest.mark.parametrize(
    "factory",
    [
        partial(IdlTarget, make=program, is_valid=is_valid),
        partial(IdlTarget, make=mutant),
    ],
    ids=["grammar", "mutation"],
)
def test_programs(factory: partial[IdlTarget]) -> None:
    report = run(factory, cases(900))
    assert [f"{f.number}: {f.detail}" for f in report.failures] == []
    assert report.cases == budget(900)
    assert report.labels["accepted"] > budget(9)
    assert report.labels["rejected"] > budget(90)


@pytest.mark.nightly
def test_octets_give_values_or_errors() -> None:
    report = run(OctetsTarget, cases(30, always=30))
    assert [f"{f.number}: {f.detail}" for f in report.failures] == []
    for name in VERSIONS:
        assert report.labels[f"{name} value"] > 0
        assert report.labels[f"{name} CdrError"] > 0


@pytest.mark.parametrize("name", FOUND)
def test_found_by_fuzzing(name: str, tmp_path: Path) -> None:
    text, codes = FOUND[name]
    result = read(tmp_path, text.encode())
    assert tuple(d.code for d in result.diagnostics) == codes, result.diagnostics


@pytest.mark.parametrize(
    "text",
    [
        "component C {}; home H manages C {};"
        " interface I { attribute C a; H f(in C b); }; typedef sequence<C> Cs;",
        "struct S {}; struct T { S a[5]; long b; }; typedef S Row[2];",
        "valuetype V { struct S { long a; }; public S b; }; typedef sequence<V> Vs;",
    ],
)
def test_what_is_generated_can_be_imported(text: str, tmp_path: Path) -> None:
    assert Generated(generate(read(tmp_path, text.encode()).model)).load()


@BOUNDED
@given(st.lists(st.sampled_from(PIECES), max_size=60))
def test_any_words(tmp_path: Path, words: list[str]) -> None:
    read(tmp_path, " ".join(words).encode())


@BOUNDED
@given(st.binary(max_size=300))
def test_any_bytes(tmp_path: Path, data: bytes) -> None:
    read(tmp_path, data)


@BOUNDED
@given(st.text(max_size=200))
def test_any_text(tmp_path: Path, text: str) -> None:
    read(tmp_path, text.encode("utf-8", "surrogatepass"))


@pytest.mark.sampled(6)
@pytest.mark.parametrize(
    "text",
    [
        "const long A = " + "(" * 5000 + "1" + ")" * 5000 + ";",
        "typedef " + "sequence<" * 2000 + "long" + ">" * 2000 + " A;",
        "module m {" * 1000,
        "".join(f"module m{n} {{" for n in cases(300)) + "};" * 1000,
        "".join(f"struct s{n} {{" for n in range(500)) + "long a;" + "} b;" * 500,
        "#if " + "(" * 1000 + "1" + ")" * 1000 + "\n#endif",
        "x" * 1_000_000,
        "struct S { long a; }; " * 15_000,
        '"\n' * 2000,
        "}" * 2000,
        "@" * 2000,
        '#include "input.idl"\n' * 3,
        "#define A0 1\n"
        + "".join(f"#define A{n + 1} A{n} A{n}\n" for n in range(40))
        + "A40",
        "#define A " + "x " * 5000 + "\n" + "A " * 5000,
        "const unsigned long A = 1 << 99999999999;",
        "struct S { long { long a; };",
        'module A {\n#include "input.idl"\n',
        "struct A; struct T { A struct A; struct T { A ::s_; };",
        "typedef long T; typedef T T; typedef T U[2];",
    ],
    ids=lambda text: text[:24].strip(),
)
def test_extremes_end_in_findings(text: str, tmp_path: Path) -> None:
    assert has_errors(read(tmp_path, text.encode()).diagnostics)


class Broken:
    """A target with a defect for each of its first cases."""

    def __init__(self, _folder: Path) -> None:
        pass

    def make(self, number: int) -> bytes:
        return b"%d" % number

    def check(self, number: int, _data: bytes) -> Iterable[str]:
        match number:
            case 0:
                raise IndexError("out of range")
            case 1:
                os._exit(3)
            case 2:
                return [str(len(bytearray(600 * 1024 * 1024)))]
        return ["good"]


@pytest.mark.nightly
def test_defects_of_all_sorts_are_noticed() -> None:
    report = run(Broken, range(5))
    assert [(f.number, f.title) for f in report.failures] == [
        (1, "the worker ended with 3"),
        (2, "MemoryError"),
    ]
    assert report.labels["good"] == 2


def test_an_exception_is_a_failure() -> None:
    report = Report()
    watch = Watch(1.0)
    attempt(Broken(Path()), 0, b"", report, watch)
    watch.end()
    assert [f.title for f in report.failures] == ["IndexError: out of range"]


def test_an_endless_loop_is_stopped() -> None:
    def endless() -> None:
        while True:
            with suppress(Exception):
                time.sleep(0)

    watch = Watch(0.02)
    try:
        with pytest.raises(TimeUp), watch.input():
            endless()
        with watch.input():
            time.sleep(0)
    finally:
        watch.end()


@pytest.mark.parametrize(
    "span",
    [
        Span("input.idl", 3, 1, 3, 2),
        Span("input.idl", 1, 9, 1, 10),
        Span("input.idl", 1, 2, 1, 1),
        Span("other.idl", 1, 1, 1, 1),
        None,
    ],
)
def test_a_finding_that_is_nowhere_is_noticed(span: Span | None) -> None:
    finding = syntax.MISSING_SEMICOLON.at(span, "a ';' is missing here")
    assert finding.severity is Severity.ERROR
    with pytest.raises(ViolationError):
        findings([finding], {"input.idl": "struct\n"}, moved=False)
