"""Users affected by a change: types, ports, instances, connections, systems, cells, nodes."""

from __future__ import annotations

from pathlib import Path

import pytest
from change_cases import Case, cases


def users(case: Case, folder: Path) -> list[tuple[str, str]]:
    """Return the users affected by the change of a case."""
    [change] = [c for c in case.changes(folder) if c.kind.code == case.code]
    return [(user.kind, user.name) for user in change.users]


SYSTEM = {name: f"<{name}>" for name in ("parts.idl", "room.xml")}
BUS = ("drive.eds", "line.toml")
GAIN = "ParameterName=Gain\nObjectType=0x7\nDataType=0x0006\nAccessType="


def of_bases(code: str, names: tuple[str, ...], before: str, after: str) -> Case:
    """Return a case that replaces a text in files of `base`."""
    folder = Path(__file__).parent / "cases" / "base"
    old = {name: (folder / name).read_text("utf-8") for name in names}
    new = {name: text.replace(before, after) for name, text in old.items()}
    assert old != new
    return Case(code, "", "", old, new)


@pytest.mark.sampled(3)
@pytest.mark.parametrize(
    ("case", "expected"),
    [
        (
            of_bases("DIF0110", tuple(SYSTEM), "double u;", "double u; double v;"),
            [
                ("type", "A"),
                ("port", "Sink.In"),
                ("port", "Source.Out"),
                ("port", "Store.In"),
                ("connection", "room:Source0.Out-Sink0.In"),
            ],
        ),
        (
            of_bases("DIF0326", tuple(SYSTEM), "publishes A", '@unit("m") publishes A'),
            [("connection", "room:Source0.Out-Sink0.In")],
        ),
        (
            of_bases("DIF0344", tuple(SYSTEM), "@default(1.0)", "@default(2.0)"),
            [
                ("instance", "room:Source0"),
                ("connection", "room:Source0.Out-Sink0.In"),
                ("system", "room"),
            ],
        ),
        (
            of_bases("DIF0533", BUS, "0x60410010", "0x60FF0020"),
            [("node", "line.left"), ("node", "line.right")],
        ),
        (
            of_bases("DIF0514", BUS, f"{GAIN}rw", f"{GAIN}ro"),
            [("node", "line.left"), ("node", "line.right")],
        ),
        (
            of_bases("DIF0552", BUS, "bit_rate = 500", "bit_rate = 250"),
            [("node", "line.left"), ("node", "line.right")],
        ),
    ],
    ids=["type", "port", "parameter", "PDO", "access", "bus"],
)
def test_users(case: Case, expected: list[tuple[str, str]], tmp_path: Path) -> None:
    assert users(case, tmp_path) == expected


BOARD = """struct tagState {{ int32_t a;{} }};
signature sDrive {{ void get( [out] struct tagState *s ); }};
celltype tDrive {{ entry sDrive eDrive; }};
cell tDrive Drive {{ }};
"""


def test_users_of_a_struct_of_cdl(tmp_path: Path) -> None:
    case = Case(
        *("DIF0442", "", ""),
        {"board.cdl": BOARD.format("")},
        {"board.cdl": BOARD.format(" int32_t b;")},
    )
    assert users(case, tmp_path) == [
        ("signature", "sDrive"),
        ("celltype", "tDrive"),
        ("cell", "Drive"),
    ]


def test_compatible_changes_break_nobody(tmp_path: Path) -> None:
    for case in cases():
        if case.breaks == "compatible" and case.code in ("DIF0116", "DIF0329"):
            assert users(case, tmp_path / case.name) == []
