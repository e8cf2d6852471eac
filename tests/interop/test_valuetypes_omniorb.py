"""Values with state compared with omniORBpy, little-endian (big-endian makes it abort).

omniORBpy splits their state into chunks where its buffer ends, so octets are compared after rtgen
has read and written them, which joins the chunks. If it used one chunk, they are equal at once.
"""

from __future__ import annotations

import importlib
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import programs
import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "compiler" / "types"))

import emitted

from rtgen.runtime.marshalling.dynamic.values import decoded, encoded
from rtgen.runtime.values import AnyValue

FILE = Path(__file__).with_name("valuetypes.idl")
Sides = tuple[Any, Any, Any]


@pytest.fixture(scope="module")
def sides(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Sides]:
    """Import rtgen's package, omniORBpy's, and omniORB."""
    omniorb = pytest.importorskip("omniORB", reason="omniORBpy is not installed")
    folder = tmp_path_factory.mktemp("omniorb")
    command = [programs.omniidl(), "-bpython", f"-C{folder}", str(FILE)]
    subprocess.run(command, check=True, capture_output=True)
    ours = emitted.emit(tmp_path_factory.mktemp("ours"), [FILE]).valued
    corba = importlib.import_module("omniORB.CORBA")
    orb = corba.ORB_init(["rtgen", "-ORBnativeCharCodeSet", "UTF-8"])
    sys.path.insert(0, str(folder))
    try:
        theirs = importlib.import_module("Valued")
    finally:
        sys.path.remove(str(folder))
    yield ours, theirs, omniorb
    orb.destroy()


def values(side: Any, box: Callable[[str], Any]) -> list[tuple[str, Any]]:
    """Return the same values on either side: the type for marshalling, and the value."""
    shared = side.V(5)
    text = box("shared text")
    circle = side.N(1, side.N(2, None))
    circle.next.next = circle
    return [
        ("V", None),
        ("V", side.V(1)),
        ("V", side.T(1, "abc")),
        ("V", side.TT(1, "s", 2.0)),
        ("T", side.TT(1, "some text", 2.0)),
        ("V", side.NT(1, "s", 2.0, 3.0)),
        ("V", side.TN(1, "s", 2.0, 3.0, 4.0)),
        ("NT", side.TN(1, "s", 2.0, 3.0, 4.0)),
        ("N", side.N(1, side.N(2, side.N(3, None)))),
        ("N", circle),
        ("HE", side.HE(side.Nothing(), 7, side.Nothing())),
        ("H", side.H(side.V(1), box("aa"), side.V(2), side.T(5, "t"), 1)),
        ("H", side.H(shared, None, shared, None, 1)),
        ("Text", box("hello")),
        ("S", side.S(shared, shared, None, shared, None, text, text)),
        (
            "S",
            side.S(
                *(side.T(1, "x"), side.T(2, "y"), side.TT(3, "z", 1.0)),
                *(side.V(5), side.V(6), box("one"), box("two")),
            ),
        ),
    ]


def test_the_same_values(sides: Sides) -> None:
    ours, theirs, omniorb = sides
    same = 0
    pairs = zip(values(ours, ours.Text), values(theirs, str), strict=True)
    for (name, value), (_, peer) in pairs:
        descriptor = getattr(ours, name)._descriptor_
        code = getattr(theirs, f"_tc_{name}")
        octets = encoded(descriptor, value, True)
        sent = omniorb.cdrMarshal(code, peer, 1)
        same += sent == octets
        read = decoded(descriptor, sent, True)
        assert encoded(descriptor, read, True) == octets, name
        back = omniorb.cdrUnmarshal(code, octets, 1)
        returned = decoded(descriptor, omniorb.cdrMarshal(code, back, 1), True)
        assert encoded(descriptor, returned, True) == octets, name
    assert same > 4


def test_values_in_an_any(sides: Sides) -> None:
    ours, theirs, omniorb = sides
    corba = importlib.import_module("omniORB.CORBA")
    peer = corba.Any(theirs._tc_T, theirs.T(4, "four"))
    sent = omniorb.cdrMarshal(corba._tc_any, peer, 1)
    value = AnyValue.from_cdr(sent)
    assert (type(value.value), value.value.x, value.value.s) == (ours.T, 4, "four")
    back = omniorb.cdrUnmarshal(corba._tc_any, value.to_cdr(), 1)
    assert (back._v.x, back._v.s) == (4, "four")
