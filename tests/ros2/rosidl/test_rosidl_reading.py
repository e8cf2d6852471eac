"""Interface files of ROS 2 to the model: parts, comments, defaults, packages."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rtgen.compiler.frontends import FrontendResult
from rtgen.compiler.frontends.kit.findings import MAX_PER_SEVERITY, Findings
from rtgen.compiler.model import Const, Member, Model, NamedType, Struct
from rtgen.facts.decoded_text import with_line_feeds
from rtgen.ros2.ros_idl import idl_of
from rtgen.ros2.rosidl import load, rules
from rtgen.ros2.rosidl.syntax import parts_of


def write(folder: Path, files: dict[str, str]) -> list[Path]:
    paths = [folder / name for name in files]
    for path, text in zip(paths, files.values(), strict=True):
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(text.encode())
    return paths


def read(folder: Path, **named: str) -> Model:
    """Return the model of files of the package `lab`: `msg_Name="..."`."""
    files = {}
    for key, text in named.items():
        kind, _, name = key.partition("_")
        files[f"lab/{kind}/{name}.{kind}"] = text
    result = load(write(folder, files), root=folder)
    assert not result.diagnostics
    return result.model


def struct(model: Model, *name: str) -> Struct:
    found = model.find(name)
    assert isinstance(found, Struct)
    return found


def types(model: Model, *name: str) -> dict[str, str]:
    return {m.name: str(m.type) for m in struct(model, *name).members}


def test_every_type(tmp_path: Path) -> None:
    text = """
        bool a
        byte b
        char c
        int8 d
        uint8 e
        int16 f
        uint16 g
        int32 h
        uint32 i
        int64 j
        uint64 k
        float32 l
        float64 m
        string n
        wstring o
        string<=5 p
        wstring<=6[] q
        int32[3] r
        int32[] s
        int32[<=4] t
        string<=7[<=8] u
        Other v
        lab/Other[2] w
        lab/msg/Other[] x
    """
    model = read(tmp_path, msg_All=text, msg_Other="int32 a")
    assert types(model, "lab", "msg", "All") == {
        "a": "boolean",
        "b": "octet",
        "c": "uint8",
        "d": "int8",
        "e": "uint8",
        "f": "short",
        "g": "unsigned short",
        "h": "long",
        "i": "unsigned long",
        "j": "long long",
        "k": "unsigned long long",
        "l": "float",
        "m": "double",
        "n": "string",
        "o": "wstring",
        "p": "string<5>",
        "q": "sequence<wstring<6>>",
        "r": "long[3]",
        "s": "sequence<long>",
        "t": "sequence<long,4>",
        "u": "sequence<string<7>,8>",
        "v": "lab::msg::Other",
        "w": "lab::msg::Other[2]",
        "x": "sequence<lab::msg::Other>",
    }


def test_constants_and_defaults(tmp_path: Path) -> None:
    text = """
        int32 X=-0x10
        float64 PI=3.5
        bool YES=True
        string NAME=it's "so"   # verbatim
        string QUOTED='a\\'b'
        uint8 small 7
        string s "a # b"
        string[] t ["a, b", 'c', d]
        float32[2] u [1, 2.5]
        bool v false
    """
    model = read(tmp_path, msg_Values=text.replace('"a # b"', '"a b"'))
    constants = {
        d.name[-1]: d.value for d in model.declarations if isinstance(d, Const)
    }
    assert constants == {
        "X": -16,
        "PI": 3.5,
        "YES": True,
        "NAME": 'it\'s "so"',
        "QUOTED": "a'b",
    }
    assert model.find(("lab", "msg", "Values_Constants", "X"))

    def default(member: Member) -> object:
        found = member.annotation("default")
        return None if found is None else found.get()

    members = struct(model, "lab", "msg", "Values").members
    assert {m.name: default(m) for m in members} == {
        "small": 7,
        "s": "a b",
        "t": "('a, b', 'c', 'd')",
        "u": "(1.0, 2.5)",
        "v": False,
    }
    assert {m.name: m.initial for m in members} == {
        "small": 7,
        "s": "a b",
        "t": ("a, b", "c", "d"),
        "u": (1.0, 2.5),
        "v": False,
    }


def test_comments(tmp_path: Path) -> None:
    text = """# What it is.
# More of it.

# Of the first.
int32 a  # In metres.

int32 b
# At the end.
"""
    found = struct(read(tmp_path, msg_Said=text), "lab", "msg", "Said")
    assert found.doc == "What it is.\nMore of it."
    assert [m.doc for m in found.members] == ["Of the first.\nIn metres.", ""]


def test_a_service(tmp_path: Path) -> None:
    model = read(tmp_path, srv_Add="int64 a\nint64 b\n---\nint64 sum\n")
    assert types(model, "lab", "srv", "Add_Request") == {
        "a": "long long",
        "b": "long long",
    }
    assert types(model, "lab", "srv", "Add_Response") == {"sum": "long long"}


def test_an_action_has_what_carries_it(tmp_path: Path) -> None:
    files = {
        "unique_identifier_msgs/msg/UUID.msg": "uint8[16] uuid\n",
        "builtin_interfaces/msg/Time.msg": "int32 sec\nuint32 nanosec\n",
        "lab/action/Go.action": "int32 to\n---\nbool there\n---\nfloat32 rest\n",
    }
    paths = write(tmp_path, files)
    result = load(paths[2:], root=tmp_path)
    assert not result.diagnostics
    assert [f.name for f in result.model.files if f.main] == [str(paths[2])]
    carried = {f.key for f in result.model.files if f.key.startswith("rtgen/")}
    assert carried == {
        f"rtgen/rosidl/action_msgs/{name}"
        for name in (
            *("srv/CancelGoal.srv", "msg/GoalInfo.msg"),
            *("msg/GoalStatus.msg", "msg/GoalStatusArray.msg"),
        )
    }
    shown = idl_of(result.model, "lab/action/Go.idl")
    for text in (
        "lab::action::Go_SendGoal_Response send_goal(in lab::action::Go_SendGoal_Request",
        "action_msgs::srv::CancelGoal_Response cancel_goal(in action_msgs::srv::Cancel",
        "lab::action::Go_GetResult_Response get_result(in lab::action::Go_GetResult_Req",
        "oneway void feedback(in lab::action::Go_FeedbackMessage",
        "oneway void status(in action_msgs::msg::GoalStatusArray",
    ):
        assert text in shown
    found = {
        "::".join(d.name[2:]): {m.name: str(m.type) for m in d.members}
        for d in result.model.declarations
        if isinstance(d, Struct) and d.name[0] == "lab"
    }
    uuid = "unique_identifier_msgs::msg::UUID"
    assert found == {
        "Go_Goal": {"to": "long"},
        "Go_Result": {"there": "boolean"},
        "Go_Feedback": {"rest": "float"},
        "Go_SendGoal_Request": {"goal_id": uuid, "goal": "lab::action::Go_Goal"},
        "Go_SendGoal_Response": {
            "accepted": "boolean",
            "stamp": "builtin_interfaces::msg::Time",
        },
        "Go_GetResult_Request": {"goal_id": uuid},
        "Go_GetResult_Response": {"status": "int8", "result": "lab::action::Go_Result"},
        "Go_FeedbackMessage": {
            "goal_id": uuid,
            "feedback": "lab::action::Go_Feedback",
        },
    }


def test_an_empty_message_has_an_octet(tmp_path: Path) -> None:
    model = read(tmp_path, msg_Nothing="# Nothing.\n", srv_Do="---\n")
    filler = {"structure_needs_at_least_one_member": "uint8"}
    assert types(model, "lab", "msg", "Nothing") == filler
    assert types(model, "lab", "srv", "Do_Request") == filler


def test_packages_are_found_beside_and_in_include_folders(tmp_path: Path) -> None:
    main, _, _ = write(
        tmp_path,
        {
            "src/lab/msg/Main.msg": "near/A a\nfar/B b\n",
            "src/near/msg/A.msg": "int32 a\n",
            "share/far/msg/B.msg": "int32 b\n",
        },
    )
    result = load([main], root=tmp_path, include=[tmp_path / "share"])
    assert not result.diagnostics
    assert [file.key for file in result.model.files] == [
        "src/near/msg/A.msg",
        "share/far/msg/B.msg",
        "src/lab/msg/Main.msg",
    ]


def test_a_file_without_folders_is_of_the_package_interfaces(tmp_path: Path) -> None:
    paths = write(tmp_path, {"Pose.msg": "Point at\n", "Point.msg": "float64 x\n"})
    result = load(paths, root=tmp_path)
    assert not result.diagnostics
    pose = struct(result.model, "interfaces", "msg", "Pose")
    assert pose.members[0].type == NamedType(("interfaces", "msg", "Point"))
    assert all(file.main for file in result.model.files)


def test_findings_are_bounded() -> None:
    findings = Findings(rules.TOO_MANY)
    parts_of("?\n" * (MAX_PER_SEVERITY + 10), "a.msg", findings)
    codes = [d.code for d in findings.diagnostics]
    assert codes == [rules.SYNTAX.code] * MAX_PER_SEVERITY + [rules.TOO_MANY.code]


PIECES = (
    ("int32", "string", "<=", "5", "[", "]", "a", "A", "=", "#", '"', "'", "---", "\n"),
    (" ", "lab/Main", "Main", "1e999", "\\", "é", "\0", "0x", "-1", ",", "\r", "\f"),
)
NEARLY = st.lists(
    st.sampled_from([piece for row in PIECES for piece in row]), max_size=40
).map("".join)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("any")


@given(NEARLY, st.sampled_from(["msg", "srv", "action"]))
def test_any_text_gives_a_model_or_errors(folder: Path, text: str, kind: str) -> None:
    paths = write(folder, {f"lab/{kind}/Main.{kind}": text})
    result: FrontendResult = load(paths, root=folder)
    assert bool(result.model.declarations) != bool(result.diagnostics)
    for found in result.diagnostics:
        assert found.span is not None
        assert found.span.line <= with_line_feeds(text).count("\n") + 1


@pytest.mark.parametrize(
    ("line", "value"),
    [
        (r'string A="a\tb"', "a\tb"),
        (r"string A=\x41\101\u0041", "AAA"),
        (r"string A=\303\244", "ä"),
        (r'string A="a\\nb"', "a\nb"),
        (r"string A=C:\dir", r"C:\dir"),
        (r"string A='it\'s'", "it's"),
        (r"string A=a\"b", 'a"b'),
        ('string A="a\tb"', "a b"),
        ("string A==b=", "=b="),
        ("string A=  ", ""),
        ("string A=表", "表"),
        (r"string A=\x23 # \x23", "#"),
        ("int32 A=012", 12),
        ("int32 A=-0x1F", -31),
        ("int32 A=0b11", 3),
        ("int32 A=1_000", 1000),
        ("uint8 A=+7", 7),
        ("float32 A=1e3", 1000.0),
        ("float64 A=.5", 0.5),
        ("bool A=TRUE", True),
        ("int32[2] a [01, 0x2]", (1, 2)),
        ("int32[<=+3] a []", ()),
        (r"""string[] a ["a\tb", 'c,d', e f ,]""", ("a\tb", "c,d", "e f")),
        (r'string[] a ["it\"s"]', ('it"s',)),
        ("string<=3[02] a [abc, '']", ("abc", "")),
    ],
)
def test_values_as_rosidl_reads_them(tmp_path: Path, line: str, value: object) -> None:
    """Compared with rosidl itself by `tests/ros2/test_rosidl_values.py`."""
    model = read(tmp_path, msg_Values=line)
    constants = [d.value for d in model.declarations if isinstance(d, Const)]
    [member] = struct(model, "lab", "msg", "Values").members
    assert (constants or [member.initial]) == [value]


def test_a_long_text_is_read_in_time(tmp_path: Path) -> None:
    """Its parts are looked at a bounded number of times."""
    inner = r"\\" * 50_000 + r"\"" * 50_000 + "ab," * 50_000
    for line in (f'string A="{inner}"', f'string[] a ["{inner}", {inner}]'):
        path = write(tmp_path, {"lab/msg/Long.msg": line})
        load(path, root=tmp_path)
