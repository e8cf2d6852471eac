"""Texts with unlimited nesting or repetition: read in bounded depth, with a finding."""

from __future__ import annotations

import pytest

from rtgen.compiler.frontends.cdl import read_text
from rtgen.compiler.inspection.models import tree
from rtgen.compiler.model import Model

SIZE = "signature s { void f( [in,size_is(%s)] const int8_t *a, [in] int32_t n ); };"
ENDLESS = {
    "parentheses": ("const int32_t N = " + "(" * 50_000, "CDL0211"),
    "signs": ("const int32_t N = " + "-" * 50_000 + "1;", "CDL0211"),
    "name spaces": ("namespace n {" * 1000, "CDL0211"),
    "pointers": ("const int32_t " + "*" * 10_000 + "N = 1;", "CDL0211"),
    "sum": (SIZE % "+".join(["n"] * 1000), "CDL0211"),
    "typedefs": (
        "typedef int32_t T0;" + "".join(f"typedef T{i} *T{i + 1};" for i in range(500)),
        "CDL0211",
    ),
    "braces": ("{" * 50_000, "CDL0200"),
    "angles": ("<" * 50_000 + "\n" + "<" * 50_000 + "\\>", "CDL0200"),
    "quotes": ("const char_t *const A = " + '"a\n' * 5000, "CDL0102"),
    "comments": ("/*" * 50_000, "CDL0101"),
    "semicolons": (";" * 50_000, "CDL0210"),
    "digits": ("const int32_t N = " + "9" * 50_000 + ";", "CDL0808"),
    "product": (
        "const int32_t N = " + " * ".join(["99999999999"] * 2000) + ";",
        "CDL0808",
    ),
    "shift": ("const int32_t N = 1 << 99999;", "CDL0806"),
    "character": ("const int8_t A = '';", "CDL0100"),
}


@pytest.mark.sampled(4)
@pytest.mark.parametrize("name", ENDLESS)
def test_endless(name: str) -> None:
    text, code = ENDLESS[name]
    unit, findings = read_text(text)
    assert code in {d.code for d in findings}
    tree(Model(tecs=(unit,)))
