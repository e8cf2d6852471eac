"""IDL as interface files of ROS 2: read back by rtgen and rosbags, or refused with a position."""

from __future__ import annotations

import random
from pathlib import Path

import pytest
from ros2_peers import DISTRIBUTIONS, installation
from seeds import cases

from rtgen import api
from rtgen.cli import run
from rtgen.compiler.backends import Options
from rtgen.compiler.layouts.ros_types import type_hash
from rtgen.compiler.model import Struct
from rtgen.ros2.backend.backend import BACKEND
from rtgen.ros2.backend.literals import comment, literal
from rtgen.ros2.backend.packages import interface_texts
from rtgen.ros2.rosidl import load
from rtgen.ros2.rosidl.values import parsed

IDL = """
#include "std_msgs/msg/Header.idl"
module Lab {
    enum Mode { IDLE, BUSY };
    typedef sequence<double, 4> Few;
    struct Base { @unit("s") double age; };
    /** A place.
        Of an arm. */
    struct path_point : Base {
        std_msgs::msg::Header header;
        boolean a; octet b; int8 d; uint8 e; short f; unsigned short g;
        long h; unsigned long i; long long j; unsigned long long k;
        float l; double m; string n; string<5> p;
        Few q; sequence<string> r; double s[3];
        Mode state;  ///< What it does.
        double minAngle;  ///< The least [rad].
    };
    struct Letter { char c; wstring text; };
    struct Route { sequence<path_point> points; };
    union Either switch (boolean) { case TRUE: long a; };
    struct WithUnion { Either part; };
    struct Outer { WithUnion inner; };
    struct Matrix { double m[2][2]; };
    struct Maybe { @optional long x; };
    struct Clash { long aB; long a_b; };
    struct Words { long class; long from; };
    exception Broken {};
    interface Arm {
        double move(in path_point where, inout long speed, out string text);
        void stop();
        void may_fail() raises (Broken);
    };
};
"""
OPTIONS = Options("robots", "", "0", ros_interfaces=True)
LEFT_OUT = [
    f"Lab::{place} has no form in ROS 2, which does not have {what}: Lab::{owner} is left out"
    for owner, place, what in (
        ("WithUnion", "WithUnion::part", "the type Lab::Either"),
        ("Outer", "Outer::inner", "the type Lab::WithUnion"),
        ("Matrix", "Matrix::m", "arrays of several dimensions"),
        ("Maybe", "Maybe::x", "optional members"),
        ("Clash", "Clash::a_b", "the name a_b beside the others"),
    )
] + ["Lab::Arm::may_fail has no form in ROS 2, which does not have exceptions"]


def test_read_back(tmp_path: Path) -> None:
    emission = BACKEND.emit(api.compile(IDL), OPTIONS)
    assert [d.message for d in emission.diagnostics] == LEFT_OUT
    assert all(d.span is not None for d in emission.diagnostics)
    paths = []
    for artifact in emission.artifacts:
        path = tmp_path / artifact.path
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(artifact.text, encoding="utf-8")
        paths.append(path)
    assert {path.relative_to(tmp_path).as_posix() for path in paths} == {
        *(
            "ros2/lab/msg/Base.msg",
            "ros2/lab/msg/PathPoint.msg",
            "ros2/lab/msg/Route.msg",
        ),
        *("ros2/lab/msg/Letter.msg", "ros2/lab/msg/Words.msg"),
        *("ros2/lab/srv/ArmMove.srv", "ros2/lab/srv/ArmStop.srv"),
    }
    result = load(paths, root=tmp_path)
    assert not result.diagnostics
    own = api.compile(IDL)
    words = (tmp_path / "ros2/lab/msg/Words.msg").read_text()
    assert words == "int32 class_value\nint32 from_value\n"
    point = own.find(("Lab", "path_point"))
    back = result.model.find(("lab", "msg", "PathPoint"))
    assert isinstance(point, Struct)
    assert isinstance(back, Struct)
    assert back.doc == "A place.\nOf an arm."
    wanted = ["double", *(str(own.unalias(m.type)) for m in point.members)]
    wanted[-2] = "unsigned long"
    assert [str(m.type) for m in back.members] == wanted
    assert [m.name for m in back.members][-2:] == ["state", "min_angle"]
    unit = back.members[0].annotation("unit")
    assert unit is not None
    assert unit.arguments == (("value", "s"),)
    reply = result.model.find(("lab", "srv", "ArmMove_Response"))
    assert isinstance(reply, Struct)
    assert [m.name for m in reply.members] == ["return_value", "speed", "text"]


def test_of_an_included_file_what_is_contained(tmp_path: Path) -> None:
    text = (
        '#include "BasicDataType.idl"\n'
        "module Lab { struct Arm { RTC::TimedLong angle; }; };\n"
    )
    emission = BACKEND.emit(api.compile(text), OPTIONS)
    assert {artifact.path for artifact in emission.artifacts} == {
        *("ros2/lab/msg/Arm.msg", "ros2/rtc/msg/TimedLong.msg", "ros2/rtc/msg/Time.msg")
    }
    assert not emission.diagnostics
    wide = text.replace("TimedLong", "TimedWChar")
    emission = BACKEND.emit(api.compile(wide), OPTIONS)
    assert [a.path for a in emission.artifacts] == ["ros2/rtc/msg/Time.msg"]
    assert [d.message.partition(" has ")[0] for d in emission.diagnostics] == [
        *("RTC::TimedWChar::data", "Lab::Arm::angle")
    ]


def test_rosbags_reads_them(tmp_path: Path) -> None:
    """Its hashes equal rtgen's; it has no `wstring`, and another definition of `char`."""
    typesys = pytest.importorskip("rosbags.typesys")
    store = typesys.get_typestore(typesys.Stores.ROS2_JAZZY)
    paths = []
    for artifact in BACKEND.emit(api.compile(IDL), OPTIONS).artifacts:
        path = tmp_path / artifact.path
        if path.suffix == ".msg":
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(artifact.text, encoding="utf-8")
            paths.append(path)
            store.register(
                typesys.get_types_from_msg(artifact.text, f"lab/msg/{path.stem}")
            )
    result = load(paths, root=tmp_path)
    assert not result.diagnostics
    model = result.model
    for name in ("Base", "PathPoint", "Route"):
        struct = model.find(("lab", "msg", name))
        assert isinstance(struct, Struct)
        assert type_hash(model, struct) == store.hash_rihs01(f"lab/msg/{name}")


@pytest.mark.nightly
@pytest.mark.peer
@pytest.mark.parametrize("distribution", DISTRIBUTIONS)
def test_rosidl_reads_those_of_boards(distribution: str) -> None:
    """The IDL beside each file has the members that rosidl's own has."""
    folder = Path(__file__).resolve().parents[2] / "generated/ros2/refrobots_board"
    script = Path(__file__).with_name("rosidl_files.py")
    lines = installation(distribution).output(script, str(folder)).splitlines()
    assert len(lines) == 7
    assert all(line.endswith(" True") for line in lines), lines


def test_of_a_project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("t.idl").write_text("module Lab { struct Base { double age; }; };\n")
    text = '[sources]\npaths = ["t.idl"]\n'
    Path("rtgen.toml").write_text(text)
    assert run(["generate", "-q"]) == 0
    assert not Path("generated/ros2").exists()
    Path("rtgen.toml").write_text(f"{text}[ros2]\ninterfaces = true\n")
    assert run(["generate", "-q"]) == 0
    assert Path("generated/ros2/lab/msg/Base.msg").read_text() == "float64 age\n"
    assert run(["check", "-q"]) == 0


EXACT = """
#include "std_msgs/msg/Header.idl"
module lab {
    module msg {
        module Place_Constants { const uint8 LOST = 1; const string NAME = "a#b"; };
        typedef double Angle;
        /** Where it is.
            Or was. */
        struct Place {
            std_msgs::msg::Header header;
            @default(1.5) Angle x;  ///< C:\\users [m]
            /** A text
                in two lines. */
            @default("say \\"#1\\"=") string text;
            @default(TRUE) boolean known;
        };
        enum Mode { IDLE, BUSY };
        struct Moded { Mode state; };
        struct Lettered { char c; };
        struct Cased { long aB; };
        struct Worded { long class; };
    };
    module srv {
        struct Find_Request { lab::msg::Place where; };
        struct Find_Response { boolean done; };
        struct Lost_Request { long x; };
    };
    module action {
        struct Go_Goal { double x; };
        struct Go_Result { double y; };
        struct Go_Feedback { double z; };
    };
};
"""


def test_names_of_ros2(tmp_path: Path) -> None:
    """Interfaces with names of ROS 2 keep names and hashes."""
    model = api.compile(EXACT)
    texts, findings = interface_texts(model)
    assert [d.message for d in findings] == [
        f"lab::{what}"
        for what in (
            "msg::Moded::state has no form in ROS 2, which does not have the type lab::msg::Mode: "
            "lab::msg::Moded is left out",
            "msg::Lettered::c has no form in ROS 2, which does not have the type char: "
            "lab::msg::Lettered is left out",
            "msg::Cased::aB has no form in ROS 2, which does not have the name aB: "
            "lab::msg::Cased is left out",
            "msg::Worded::class has no form in ROS 2, which does not have the name class, "
            "a word of C++ or Python: lab::msg::Worded is left out",
            "srv::Lost has no form in ROS 2, which does not have srv files without Lost_Response",
        )
    ]
    files = {each.path: each for each in texts}
    assert files.keys() == {
        *("lab/msg/Place.msg", "lab/srv/Find.srv", "lab/action/Go.action")
    }
    assert files["lab/msg/Place.msg"].packages == {"std_msgs"}
    assert files["lab/msg/Place.msg"].text == (
        "# Where it is.\n# Or was.\n\n"
        'uint8 LOST=1\nstring NAME="a\\x23b"\n\n'
        "std_msgs/Header header\n"
        "float64 x 1.5  # C:\\\\\\\\users [m]\n"
        "# A text\n# in two lines.\n"
        'string text "say \\x22\\x231\\x22\\x3d"\n'
        "bool known true\n"
    )
    paths = []
    for name, each in files.items():
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(each.text, encoding="utf-8")
        paths.append(path)
    back = load(paths, root=tmp_path).model
    for name in ("msg/Place", "srv/Find_Request", "action/Go_Feedback"):
        key = ("lab", *name.split("/"))
        own, other = model.find(key), back.find(key)
        assert isinstance(own, Struct)
        assert isinstance(other, Struct)
        assert type_hash(model, own) == type_hash(back, other)


def test_texts_of_strings() -> None:
    """Each text has a literal that is read back as it is; comments are read at all."""
    pieces = ("\\", '"', "'", "#", "=", "\n", "\t", "表", "\x85", "\u2028", "n", "x4")
    for seed in cases(500):
        drawn = random.Random(seed)
        text = "".join(drawn.choices(pieces, k=drawn.randint(0, 6)))
        written = literal(text, None)
        assert not {"#", "=", "\n", "\t"} & {*written}
        assert parsed(written, None) == text
        parsed(f"a{comment(text)}", None)
