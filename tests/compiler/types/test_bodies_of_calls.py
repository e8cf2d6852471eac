"""Bodies of calls are marshalled as structs with the same members (CORBA 3.3 part 2, 9.4)."""

from __future__ import annotations

import random
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest
from generated_projects import project
from seeds import cases

from rtgen.runtime.distribution.rpc_types import interface_types
from rtgen.runtime.services.call_types import raised_body
from rtgen.runtime.services.calls import calls_of, decoded

TYPES = (
    *("long", "double", "string", "octet", "Few", "wstring", "char", "Pair", "Mode"),
    *("Record", "unsigned long long", "Values"),
)
FURTHER = (("any", "Object", "Other"), ("Table", "Tables"))
"""Types in classic CDR only, and in XCDR only: they do not go together."""
NAMES = ("a", "class", "value", "to_cdr", "self", "text_" * 8 + "x", "idl", "ClassVar")


def _interface(draw: random.Random, number: int) -> str:
    """Return an interface, and a struct for each request and each reply."""
    name = f"Service{'Long' * draw.choice((0, 0, 9))}{number}"
    lines = [f"  interface {name} {{"]
    structs = []
    for place in range(draw.choice((1, 3, 12))):
        types = (*TYPES, *draw.choice(FURTHER))
        parameters = [
            (draw.choice(("in", "out", "inout")), draw.choice(types), each)
            for each in draw.sample(NAMES, draw.randint(0, 3))
        ]
        result = draw.choice(types)
        called = f"call{'_of_a_long_name' * draw.choice((0, 0, 4))}{place}"
        listed = ", ".join(f"{way} {type_} {each}" for way, type_, each in parameters)
        raised = draw.choice(("", " raises (Failed)"))
        lines.append(f"    {result} {called}({listed}){raised};")
        given = [f"{t} {n};" for way, t, n in parameters if way != "out"]
        got = [f"{t} {n};" for way, t, n in parameters if way != "in"]
        for kind, members in (("request", given), ("reply", [f"{result} r;", *got])):
            if members:
                structs.append(
                    f"  struct {name}_{called}_{kind} {{ {' '.join(members)} }};"
                )
    return "\n".join([*lines, "  };", *structs])


def _definitions(draw: random.Random) -> str:
    interfaces = "\n".join(_interface(draw, number) for number in range(4))
    return f"""\
module Lab {{
  enum Mode {{ OFF, ON }};
  typedef sequence<long> Values;
  typedef sequence<double, 4> Few;
  struct Record {{ long x; string text; }};
  typedef Record Pair[2];
  @mutable struct Table {{ @optional long x; string text; }};
  typedef sequence<Table> Tables;
  exception Failed {{ string reason; Mode state; }};
  struct FailedReply {{ string id; string reason; Mode state; }};
  exception Partly {{ @optional long done; string reason; @optional Record last; }};
  struct PartlyReply {{ string id; @optional long done; string reason; @optional Record last; }};
  interface Task {{ void begin() raises (Partly); }};
  interface Other {{ void ping(); }};
{interfaces}
}};
"""


def _members(body: Any) -> list[tuple[str, object]]:
    return [(member.name, member.type) for member in body._descriptor_.members]


@pytest.mark.sampled(4)
@pytest.mark.random
@pytest.mark.parametrize("number", cases(30))
def test_they_are_equal(tmp_path: Path, number: int) -> None:
    files = {"services.idl": _definitions(random.Random(number))}
    with project(tmp_path / "lab", files, "lab"):
        lab: Any = import_module("lab.lab")
        compared = 0
        for name in [n for n in dir(lab) if n.startswith("Service")]:
            interface = getattr(lab, name)
            if not hasattr(interface, "_calls_") or name.endswith(("Stub", "Skeleton")):
                continue
            for operation, call in calls_of(interface).items():
                for kind, body in (("request", call.request), ("reply", call.reply)):
                    struct = getattr(lab, f"{name}_{operation}_{kind}", None)
                    assert (struct is None) == (body is None)
                    if struct is None:
                        continue
                    expected = _members(struct)
                    first = [("_result", expected[0][1])] if kind == "reply" else []
                    assert _members(body) == first + expected[len(first) :]
                    value = struct()
                    values = [getattr(value, each) for each in struct.__match_args__]
                    for little_endian in (True, False):
                        octets = value.to_cdr(little_endian)
                        assert body(*values).to_cdr(little_endian) == octets
                        assert decoded(body, octets, little_endian) == tuple(values)
                    compared += 1
                assert [each for _, each in call.raises] in ([], [lab.Failed])
        assert compared > 8
        body = raised_body(lab.Failed)
        values = ["IDL:Lab/Failed:1.0", "why", lab.Mode.ON]
        assert body(*values).to_cdr() == lab.FailedReply(*values).to_cdr()
        assert raised_body(lab.Failed) is body


def test_exceptions_with_optional_members(tmp_path: Path) -> None:
    files = {"services.idl": _definitions(random.Random(0))}
    with project(tmp_path / "lab", files, "lab"):
        lab: Any = import_module("lab.lab")
        body = raised_body(lab.Partly)
        operation = interface_types(lab.Task).operations["begin"]
        [(raised, _)] = operation.exceptions.values()
        for done, last in ((None, None), (3, None), (None, lab.Record(1, "a"))):
            values = [done, "why", last]
            given = ["IDL:Lab/Partly:1.0", *values]
            for little_endian in (True, False):
                octets = body(*given).to_cdr(little_endian)
                assert octets == lab.PartlyReply(*given).to_cdr(little_endian)
                assert decoded(body, octets, little_endian) == tuple(given)
                octets = raised(*values).to_xcdr1(little_endian)
                assert raised.from_xcdr1(octets, little_endian) == raised(*values)
