"""Constructs without a reference type, compared with omniORBpy: unions, fixed, recursion."""

from __future__ import annotations

import importlib
import subprocess
import sys
from collections.abc import Iterator
from decimal import Decimal
from pathlib import Path
from typing import Any

import programs
import pytest
from padding import masked, padding

sys.path.insert(0, str(Path(__file__).parents[1] / "compiler" / "types"))

import emitted

FILE = Path(__file__).with_name("constructs.idl")


@pytest.fixture(scope="module")
def sides(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Any, Any]]:
    """Return rtgen's package of the module Constructs, and omniORBpy's."""
    pytest.importorskip("omniORB", reason="omniORBpy is not installed")
    folder = tmp_path_factory.mktemp("omniorb")
    command = [programs.omniidl(), "-bpython", f"-C{folder}", str(FILE)]
    subprocess.run(command, check=True, capture_output=True)
    package = emitted.emit(tmp_path_factory.mktemp("ours"), [FILE])
    ours = importlib.import_module(f"{package.__name__}.constructs")
    orb = importlib.import_module("omniORB.CORBA").ORB_init(
        ["rtgen", "-ORBnativeCharCodeSet", "UTF-8"]
    )
    sys.path.insert(0, str(folder))
    try:
        theirs = importlib.import_module("Constructs")
    finally:
        sys.path.remove(str(folder))
    yield ours, theirs
    orb.destroy()


def values(side: Any, fixed: Any) -> dict[str, list[Any]]:
    """Return the same values on either side, by type.

    `fixed` makes a value from digits, scale and text.
    """
    tree = side.Tree
    mixed = side.Mixed(
        1,
        side.ByLong(2, 1.5),
        side.ByBoolean(False, [1.0]),
        [side.ByChar("a", -5), side.ByChar("q", side.k1)],
        side.ByEnum(side.k0, [3, 4]),
        "abc",
        ["x", "yy", ""],
        [True, False],
        -9,
    )
    return {
        "ByLong": [side.ByLong(2, 1.5), side.ByLong(-3, "hé"), side.ByLong(9, None)],
        "ByBoolean": [side.ByBoolean(True, 7), side.ByBoolean(False, [1.0, 2.0])],
        "ByChar": [side.ByChar("a", -5), side.ByChar("z", side.k2)],
        "ByEnum": [side.ByEnum(side.k1, "wé"), side.ByEnum(side.k0, [1, 2])],
        "Money": [side.Money(1, fixed(5, 2, "-123.45"), fixed(4, 1, "7.5"), 2.0)],
        "Wide": [side.Wide("é", "abé", 3, 2.0)],
        "Mixed": [mixed],
        "Failure": [side.Failure("hi", side.ByBoolean(True, 3), b"abc")],
        "Tree": [tree(1, [tree(2, [], 1.0), tree(3, [tree(4, [], 2.0)], 3.0)], 4.0)],
    }


@pytest.mark.parametrize("little_endian", [True, False])
def test_the_same_octets(sides: tuple[Any, Any], little_endian: bool) -> None:
    omniorb = importlib.import_module("omniORB")
    ours, theirs = sides
    peers = values(
        theirs, lambda digits, scale, text: omniorb.fixed(digits, scale, text)
    )
    for name, several in values(
        ours, lambda digits, scale, text: Decimal(text)
    ).items():
        code = getattr(theirs, f"_tc_{name}")
        for value, peer in zip(several, peers[name], strict=True):
            octets = value.to_cdr(little_endian)
            reference = omniorb.cdrMarshal(code, peer, int(little_endian))
            if (
                name == "Failure"
            ):  # omniORB's begins with the repository id, as a reply does
                assert reference.endswith(octets)
                continue
            places = padding(value._descriptor_, octets, little_endian)
            assert octets == masked(reference, places), name
            assert type(value).from_cdr(reference, little_endian) == value
            if name != "Wide":  # omniORBpy cannot read a wchar that it wrote
                back = omniorb.cdrUnmarshal(code, octets, int(little_endian))
                again = omniorb.cdrMarshal(code, back, int(little_endian))
                assert masked(again, places) == octets, name
