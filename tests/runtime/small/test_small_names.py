"""Names with a meaning in Python, in the runtime or in generated code cause no clash."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from micropython import micropython

from rtgen.cli import run

IDL = """
module A_B { struct C { long x; }; struct Numbers { long v; }; };
module A { struct B_C { long y; }; };
module Self { struct One { long x; }; };
module Deep { module M { struct Two { long y; }; }; };
module M {
    enum Word { NoneOf, pass, lambda };
    struct Point { double x; double y; };
    struct Odd {
        long self; long class; sequence<double, 3> Values; sequence<Point, 2> Numbers;
        octet bytes[4]; Point M_Point; string<9> bounded; sequence<octet, 5> exactly;
        long len; long range; long i; long wire; long other; long count;
        sequence<long, 2> copy_items; double copy_array[2]; long ord;
        sequence<string<3>, 2> names; Word print; long _in;
        Point _copy_; long _put_; long to_cdr; long instance_name;
    };
    struct Base { long a; };
    struct Derived : Base { long b; };
    struct Nothing { };
    struct Mixed { A_B::C one; A::B_C two; A_B::Numbers three; Nothing four; };
};
struct Numbers { long z; sequence<double, 2> d; };
struct Values { sequence<Numbers, 3> z; };
struct len { string<9> s; };

@rtc(category="C", vendor="v", version="1.0.0", rate=20.0)
component Odd_Names {
    consumes ::M::Odd rate;
    publishes ::M::Odd state;
    consumes ::M::Mixed self;
    publishes ::M::Mixed ticks;
    consumes Numbers request;
    publishes Values buffer;
    publishes len cycle;
    consumes ::M::Derived class;
    consumes ::M::Base type_name;
    publishes Self::One Component;
    publishes Deep::M::Two name;
    @name("name") consumes Deep::M::Two other;
    attribute long self_;
    attribute long class_;
    attribute long M2;
    @default(::M::pass) attribute ::M::Word m;
    @default("a\\"b") attribute string slots;
};

@rtc(category="C", vendor="v", version="1.0.0", rate=0.5)
component Component { consumes ::M::Point p; attribute long config; };
"""

COMMON = """
from robots import Numbers, Values, a, a_b, len as len_, m, self as self_module
from robots.deep import m as deep_m
from robots.components.odd_names import Odd_NamesBase
from robots.components.component import ComponentBase

def samples():
    point = m.Point(1.0, 2.0)
    yield m.Odd(self=1, class_=2, Values=[1.0], Numbers=[point], bytes=b"abcd", M_Point=point,
        bounded="x", exactly=b"12", len=3, range=4, i=5, wire=6, other=7, count=8,
        copy_items=[9], copy_array=[1.0, 2.0], ord=10, names=["y"], print=m.Word.pass_, in_=11,
        copy_=point, put_=12, to_cdr_=13, instance_name=14)
    yield m.Mixed(one=a_b.C(1), two=a.B_C(2), three=a_b.Numbers(3))
    yield m.Derived(a=1, b=2)
    yield m.Nothing()
    yield Values([Numbers(1, [2.0])])
    yield len_("z")
    yield self_module.One(5)
    yield deep_m.Two(6)

def lines_of(component):
    config = component.config
    attributes = [(name, getattr(component, name)) for name in dir(component)]
    yield sorted(
        (name, port.name) for name, port in attributes
        if type(port).__name__ in ("InPort", "OutPort")
    )
    yield sorted((name, getattr(config, name)) for name in dir(config) if name[:1] != "_")
"""

EMBEDDED = """
for sample in samples():
    print(sample.to_cdr(little_endian=True).hex())
for base in (Odd_NamesBase, ComponentBase):
    for line in lines_of(base()):
        print([(name, getattr(value, "value", value)) for name, value in line])
"""

SMALL = """
from rtgen.runtime import SECOND, System, to_cdr
buffer = bytearray(500)
for sample in samples():
    copied = type(sample)()
    copied._copy_(sample)
    print(bytes(buffer[: to_cdr(copied, buffer)]).hex() or "")  # b"" of MicroPython
system = System()
for base in (Odd_NamesBase, ComponentBase):
    component = base()
    for line in lines_of(component):
        print(line)
    system.add(component)
    system.activate(component)
    system.run(system.time + SECOND)
    assert (system.state(component), system.ticks(component) > 0) == (2, True)
system.close()
"""


def printed(code: str, folder: Path) -> str:
    result = subprocess.run(
        [sys.executable, "-c", COMMON + code],
        env={**os.environ, "PYTHONPATH": str(folder)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert result.returncode == 0, result.stderr
    return result.stdout


def test_names_are_those_of_the_embedded_target(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "odd.idl").write_text(IDL, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    assert run(["generate", "odd.idl", "--target", "small", "--no-cache", "-q"]) == 0
    generated = tmp_path / "generated"
    embedded = printed(EMBEDDED, generated)
    assert len(embedded.splitlines()) == 12
    assert printed(SMALL, generated / "small") == embedded
    assert micropython(COMMON + SMALL, generated / "small") == embedded
