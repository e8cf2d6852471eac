"""Random renames of what does not travel: `rtgen diff` never says `wire`.

Octets of values hold no names of members, enumerators, types or parameters; frames of CAN none of
nodes. What does travel keeps its name: operations and attributes of IDL, interfaces, types of IDL
(their repository ids), members of mutable types with a hash of their name as id.
"""

from __future__ import annotations

import re
from contextlib import ExitStack
from pathlib import Path
from random import Random

import pytest
import seeds

from rtgen.compiler.layouts.signature_digest import signature_digest
from rtgen.compiler.model import Model
from rtgen.compiler.model.tecs import Signature
from rtgen.tools.diff.changes import Change, Wire
from rtgen.tools.diff.compare import compare
from rtgen.tools.diff.reading import Source, opened

IDL = """
module Lab {
    const long LIMIT = 3;
    enum Kind { FAST, SLOW, @value(7) IDLE };
    @bit_bound(8) bitmask Flags { READY, @position(4) BUSY };
    bitset Bits { bitfield<3> low; bitfield<5> high; bitfield<2> rest; };
    typedef sequence<long, LIMIT> Row;
    typedef Row Rows[2];
    struct Inner { long first; Kind kind_; Flags flags_; Bits bits_; };
    struct Twin { long first; Kind kind_; Flags flags_; Bits bits_; };
    struct Outer { Inner one; Twin two; Rows rows_; sequence<Twin> twins; };
    @appendable struct Grown { @default(FAST) Kind how; Outer all_; };
    @mutable struct Loose { @id(1) long count; @id(5) Row line_; };
    union Choice switch (Kind) {
        case FAST: long quick; case SLOW: Inner slow_; default: Row other;
    };
    union Ticks switch (long) { case LIMIT: long exact; case 4: case 5: string text_; };
    exception Refused { string why; Kind cause; };
    native Handle;
    local interface Near { void take(in Handle given); };
    interface Base {
        void go(in long speed, out Outer place, inout Choice chosen) raises (Refused);
        Rows get(in Kind wanted);
    };
};
component Driver {
    consumes Lab::Outer target;
    publishes Lab::Grown state_;
    provides Lab::Base service;
    @unit("m") @default(0.5) attribute double wheel;
    attribute Lab::Kind mode_;
};
"""
IDL_NAMES = [
    *("LIMIT", "FAST", "SLOW", "IDLE", "READY", "BUSY", "low", "high", "rest"),
    *("Row", "Rows", "first", "kind_", "flags_", "bits_", "one", "two", "rows_"),
    *("twins", "how", "all_", "count", "line_", "quick", "slow_", "other"),
    *("exact", "text_", "why", "cause", "Handle", "given", "speed", "place"),
    *("chosen", "wanted", "wheel", "mode_", "target", "state_", "service"),
]

HEADER = """
typedef int ER;
typedef struct { int across; int along; } tPoint;
struct tagBox { tPoint least, most; };
typedef struct { struct { short inner_a; } part; struct tagBox box; } tBoxed, *pBoxed;
typedef struct tagLink { tPoint here; unsigned char marks[3]; } tLink;
enum tagState { STOPPED, MOVING };
"""
CDL = """
import_C( "types.h" );
const int32_t MOST = 4;
struct tagPose { int32_t east; double64_t north; };
struct tagSame { int32_t east; double64_t north; };
typedef struct { struct tagPose from_; struct tagSame to_; int16_t cells[MOST]; } tWay;
typedef int16_t tSpeed;
namespace nArm { struct tagJoint { int32_t angle; }; };
signature sMove {
    ER go( [in] const tPoint *point, [out] struct tagPose *pose );
    int32_t way( [in] const tWay *ways, [in] tSpeed speed );
    ER fill( [in, size_is(length, MOST)] const struct tagSame *items, [in] int32_t length );
    void box( [in] const tBoxed *boxed, [in] const tLink *link, [out] tBoxed *result );
    [oneway] void note( [in, string(16)] const char_t *text );
};
signature sArm { ER turn( [in] const struct tagPose *goal ); };
celltype tServer { entry sMove eMove; entry sArm eArm; attr { int32_t rate = 3; }; };
[active] celltype tClient { call sMove cMove; call sArm cArm; var { int32_t ticks = 0; }; };
cell tServer Server { };
cell tClient Client { cMove = Server.eMove; cArm = Server.eArm; };
"""
CDL_NAMES = [
    *("tPoint", "tagBox", "tBoxed", "pBoxed", "tagLink", "tLink", "tagState"),
    *("STOPPED", "MOVING", "MOST", "tagPose", "tagSame", "tWay", "tSpeed"),
    *("nArm", "tagJoint", "sMove", "sArm", "tServer", "tClient", "Server"),
    *("Client", "eMove", "eArm", "cMove", "cArm", "ticks"),
]
"""Names that are no part of a signature's digest."""

TYPES = [name for name in CDL_NAMES if name not in ("sMove", "sArm")]
"""A signature of which all names are new is another one."""

IN_DIGEST = [
    *("across", "along", "least", "most", "inner_a", "part", "box", "here"),
    *("marks", "east", "north", "from_", "to_", "cells", "angle", "point"),
    *("pose", "ways", "speed", "items", "length", "boxed", "link", "result"),
    *("text", "goal", "go", "way", "fill", "note", "turn"),
]
"""Names of members, functions and parameters: no octets, but parts of the digest."""

BUS = """
[bus]
bit_rate = 500

[device.drive]
eds = "drive.eds"

[node.left]
device = "drive"
id = 1

[node.right]
device = "drive"
id = 2
"""
BUS_NAMES = ["drive", "left", "right", "Position", "Speed", "Identity"]


def renamed(text: str, names: dict[str, str]) -> str:
    """Return a text with other names, as whole words."""
    pattern = re.compile(rf"\b({'|'.join(names)})\b")
    return pattern.sub(lambda match: names[match[1]], text) if names else text


def fresh(random: Random, names: list[str]) -> dict[str, str]:
    """Return new names for some or all of the names."""
    share = random.choice((1, 2, len(names) // 2, len(names)))
    chosen = random.sample(names, min(share, len(names)))
    return {name: f"n{number}_{name}" for number, name in enumerate(chosen)}


def changes(
    folder: Path, texts: dict[str, str], names: dict[str, str]
) -> tuple[list[Change], list[Model]]:
    """Return the changes by renames in the definitions, and both models."""
    sources = []
    for label in ("old", "new"):
        below = folder / label
        below.mkdir(parents=True)
        for file, text in texts.items():
            made = renamed(text, names) if label == "new" else text
            name = renamed(file, names) if label == "new" else file
            (below / name).write_text(made, encoding="utf-8")
        sources.append(Source(label, below))
    with ExitStack() as stack:
        old, new = (stack.enter_context(opened(each)) for each in sources)
        return compare(old, new), [old.model, new.model]


def wires(found: list[Change]) -> list[str]:
    return [f"{c.kind.code} {c.message} {c.wires}" for c in found if c.wires]


def digests(model: Model) -> list[str]:
    """Return the digests of the signatures, in order."""
    (unit,) = model.tecs
    return [
        signature_digest(unit, each)
        for each in unit.declarations
        if isinstance(each, Signature)
    ]


@pytest.fixture(autouse=True)
def elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Work in a folder without a project around."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.random
def test_names_in_idl(tmp_path: Path) -> None:
    random = Random(seeds.seed())
    for number in range(seeds.budget(30)):
        names = fresh(random, IDL_NAMES)
        found, _ = changes(tmp_path / str(number), {"lab.idl": IDL}, names)
        assert found, names
        assert wires(found) == [], names


@pytest.mark.random
def test_names_in_cdl_and_headers(tmp_path: Path) -> None:
    random = Random(seeds.seed())
    for number in range(seeds.budget(30)):
        in_digest = random.random() < 0.3
        names = fresh(random, [*IN_DIGEST, *TYPES] if in_digest else CDL_NAMES)
        texts = {"main.cdl": CDL, "types.h": HEADER}
        found, models = changes(tmp_path / str(number), texts, names)
        old, new = map(digests, models)
        if names.keys().isdisjoint(IN_DIGEST):
            assert old == new
        assert wires(found) == [], names


@pytest.mark.random
def test_names_on_a_bus(tmp_path: Path) -> None:
    eds = Path(__file__).parent / "cases" / "base" / "drive.eds"
    random = Random(seeds.seed())
    texts = {"line.toml": BUS, "drive.eds": eds.read_text(encoding="utf-8")}
    for number in range(seeds.budget(10)):
        names = fresh(random, BUS_NAMES)
        found, _ = changes(tmp_path / str(number), texts, names)
        assert wires(found) == [], names


@pytest.mark.parametrize(
    ("old", "new", "wire"),
    [
        ("int across;", "short across;", Wire.TDR),
        ("struct tagBox box;", "tPoint box;", Wire.TDR),
        ("marks[3]", "marks[4]", Wire.TDR),
        ("struct tagSame to_;", "tPoint to_;", Wire.TDR),
        ("int32_t angle", "int16_t angle", None),
    ],
)
def test_other_octets_are_found_however_deep(
    old: str, new: str, wire: Wire | None, tmp_path: Path
) -> None:
    """A struct of a header, which only another struct uses, is part of the messages, too."""
    texts = {"main.cdl": CDL, "types.h": HEADER}
    assert sum(text.count(old) for text in texts.values()) == 1
    for label in ("old", "new"):
        folder = tmp_path / label
        folder.mkdir()
        for file, text in texts.items():
            made = text.replace(old, new) if label == "new" else text
            (folder / file).write_text(made, encoding="utf-8")
    with ExitStack() as stack:
        versions = [
            stack.enter_context(opened(Source(label, tmp_path / label)))
            for label in ("old", "new")
        ]
        found = compare(*versions)
    assert ({w for c in found for w in c.wires} == {wire}) if wire else found
