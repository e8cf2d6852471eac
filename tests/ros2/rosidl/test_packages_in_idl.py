"""Packages of ROS 2 in include folders: interface files, IDL beside them, IDL alone, other IDL."""

from __future__ import annotations

from pathlib import Path

import pytest

from rtgen import api
from rtgen.compiler import compilation
from rtgen.compiler.diagnostics import Severity
from rtgen.compiler.frontends import FrontendResult
from rtgen.compiler.frontends.kit.memo import Memo
from rtgen.compiler.model import Const, Interface, Model, Struct
from rtgen.compiler.project.loading import load, with_arguments

TEXT_IDL = """\
// generated from rosidl_adapter/resource/msg.idl.em
// with input from lab/msg/Text.msg
// generated code does not contain a copyright notice

#include "builtin_interfaces/msg/Time.idl"

module lab {
  module msg {
    typedef double double__2[2];
    typedef builtin_interfaces::msg::Time builtin_interfaces__msg__Time;
    typedef builtin_interfaces__msg__Time builtin_interfaces__msg__Time__2[2];
    module Text_Constants {
      @verbatim (language="comment", text=
        "What it is.")
      const string KIND = "a\\"b";
      const int8 LOW = -5;
      const float RATIO = 0.5;
    };
    @verbatim (language="comment", text=
      "A text." "\\n"
      "Of any kind.")
    struct Text {
      @default (value="so")
      wstring string;

      @verbatim (language="comment", text=
        "How long.")
      @unit (value="m")
      double__2 sequence;

      builtin_interfaces__msg__Time__2 stamps;

      @default (value="(1, -2)")
      sequence<int16, 3> few;

      @default (value="('a', 'b\\\\'c')")
      sequence<string<5>> names;

      @default (value=TRUE)
      boolean ok;

      uint8 structure_needs_at_least_one_member_too;
    };
  };
};
"""
TEXT_MSG = """\
# A text.
# Of any kind.

# What it is.
string KIND="a\\"b"
int8 LOW=-5
float32 RATIO=0.5

wstring string "so"
# How long.
float64[2] sequence # [m]
builtin_interfaces/Time[2] stamps
int16[<=3] few [1, -2]
string<=5[] names [a, "b'c"]
bool ok True
uint8 structure_needs_at_least_one_member_too
"""
ACTION_IDL = """\
// generated from rosidl_adapter/resource/action.idl.em
module lab {
  module action {
    struct Go_Goal {
      uint8 structure_needs_at_least_one_member;
    };
    struct Go_Result {
      boolean done;
    };
    module Go_Feedback_Constants {
      const uint8 FEW = 3;
    };
    struct Go_Feedback {
      float left;
    };
  };
};
"""
BY_HAND = "module lab { module msg { struct Keyed { @key long key; double x; }; }; };"


def packages(folder: Path, **texts: str) -> Path:
    """Write files of the package `lab`: `msg_Text_idl=...`."""
    for key, text in texts.items():
        kind, name, suffix = key.split("_")
        path = folder / "lab" / kind / f"{name}.{suffix}"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    return folder


def model_of(text: str, folder: Path) -> Model:
    result = api.read(text, include=[folder])
    assert not [d for d in result.diagnostics if d.severity is not Severity.NOTE]
    return result.model


def facts(model: Model) -> dict[str, object]:
    """Return what a message has in common, whatever it was read from."""
    text = model.find(("lab", "msg", "Text"))
    assert isinstance(text, Struct)
    constants = {
        d.name[-1]: d.value for d in model.declarations if isinstance(d, Const)
    }
    return {
        "doc": text.doc,
        "constants": constants,
        "members": [
            (m.name, str(m.type), m.initial, [a.name for a in m.annotations])
            for m in text.members
        ],
    }


def test_each_form_of_a_message_is_the_same(tmp_path: Path) -> None:
    include = '#include "lab/msg/Text.idl"\n'
    found = [
        facts(model_of(include, packages(tmp_path / str(number), **texts)))
        for number, texts in enumerate(
            (
                {"msg_Text_msg": TEXT_MSG},
                {"msg_Text_idl": TEXT_IDL},
                {"msg_Text_msg": TEXT_MSG, "msg_Text_idl": "not read"},
            )
        )
    ]
    assert found[0] == found[1] == found[2]
    assert found[0]["constants"] == {"KIND": 'a"b', "LOW": -5, "RATIO": 0.5}
    assert found[0]["members"] == [
        ("string", "wstring", "so", ["default"]),
        ("sequence", "double[2]", None, ["unit"]),
        ("stamps", "builtin_interfaces::msg::Time[2]", None, []),
        ("few", "sequence<short,3>", (1, -2), ["default"]),
        ("names", "sequence<string<5>>", ("a", "b'c"), ["default"]),
        ("ok", "boolean", True, ["default"]),
        ("structure_needs_at_least_one_member_too", "uint8", None, []),
    ]


def test_an_action_has_its_interfaces(tmp_path: Path) -> None:
    folder = packages(tmp_path, action_Go_idl=ACTION_IDL)
    model = model_of('#include "lab/action/Go.idl"\n', folder)
    for name in ("Go", "Go_Events"):
        assert isinstance(model.find(("lab", "action", name)), Interface)
    assert model.find(("lab", "action", "Go_SendGoal_Request"))
    assert model.find(("lab", "action", "Go_Feedback_Constants", "FEW"))


def test_other_idl_is_plain(tmp_path: Path) -> None:
    folder = packages(tmp_path, msg_Keyed_idl=BY_HAND)
    keyed = model_of('#include "lab/msg/Keyed.idl"\n', folder).find(
        ("lab", "msg", "Keyed")
    )
    assert isinstance(keyed, Struct)
    assert keyed.members[0].annotation("key")


@pytest.mark.parametrize(
    "change",
    [
        ("double__2 sequence", "double__3 sequence"),
        ("module msg", "module srv"),
        ("struct Text", "struct Other"),
        ("boolean ok;", "boolean ok, more;"),
        ("const int8 LOW = -5", "const int8 LOW = 500"),
        ("sequence<int16, 3>", "sequence<sequence<int16>, 3>"),
        ("sequence<int16, 3>", f"{'sequence<' * 50_000} x"),
        ("sequence<int16, 3>", "sequence<int16, 3.5>"),
        ("sequence<int16, 3>", f"sequence<int16, {'9' * 5_000}>"),
        ("string<5>", "string<0x5>"),
        ("string<5>", "string<0>"),
        ("double__2[2]", "double__2[2][3]"),
        ("boolean ok;", "@key boolean ok;"),
        ("boolean ok;", "map<string, long> ok;"),
        ('(value="(1, -2)")', '(value="(1, x)")'),
        ('text=\n        "How', "text= How"),
        ("};\n};\n", "};\n"),
        ("};\n};\n", "};\n};\nstruct More { long x; };\n"),
        ("boolean ok;", 'boolean ok; /* "'),
        ("boolean ok;", "boolean ok; $"),
    ],
)
def test_a_message_that_is_not_in_the_form_is_refused(
    tmp_path: Path, change: tuple[str, str]
) -> None:
    """For a message that contains it, of which there is no other file."""
    assert change[0] in TEXT_IDL
    packages(
        tmp_path,
        msg_Text_idl=TEXT_IDL.replace(*change),
        msg_Main_msg="Text text\n",
    )
    result = api.read(tmp_path / "lab" / "msg" / "Main.msg")
    assert [d.code for d in result.diagnostics] == ["ROS0102"]
    assert "not IDL in the form that ROS 2 generates" in result.diagnostics[0].message


def test_an_error_in_an_included_message_is_reported_once(tmp_path: Path) -> None:
    folder = packages(tmp_path, msg_Text_msg="int32 a oops\n")
    text = '#include "lab/msg/Text.idl"\nstruct S { lab::msg::Text text; };\n'
    result = api.read(text, include=[folder])
    assert [d.code for d in result.diagnostics] == ["ROS0106"]
    span = result.diagnostics[0].span
    assert span is not None
    assert span.file.endswith("lab/msg/Text.msg")


def test_sources_are_read_once(tmp_path: Path) -> None:
    packages(
        tmp_path,
        msg_Text_msg=TEXT_MSG,
        msg_Text_idl="not read",
        action_Go_idl=ACTION_IDL,
        msg_Keyed_idl=BY_HAND,
    )
    result = api.read(tmp_path)
    assert not result.diagnostics
    files = {Path(file.name).name for file in result.model.files if file.main}
    assert files == {"Text.msg", "Go.idl", "Keyed.idl"}


def test_a_changed_message_is_read_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Results of reading are kept while the interface files are as they were."""
    monkeypatch.chdir(tmp_path)
    packages(Path("share"), msg_Text_msg="Part part\n", msg_Part_msg="int32 a\n")
    Path("t.idl").write_text('#include "lab/msg/Text.idl"\n')
    project = with_arguments(load(), paths=["t.idl"], include=["share"])
    memo = Memo()

    def members() -> list[str]:
        memo.begin()
        found: FrontendResult = compilation.read(project, memo=memo)
        part = found.model.find(("lab", "msg", "Part"))
        assert isinstance(part, Struct)
        return [member.name for member in part.members]

    assert members() == ["a"]
    assert members() == ["a"]
    packages(Path("share"), msg_Part_msg="int32 a\nint32 b\n")
    assert members() == ["a", "b"]
    packages(Path("share"), msg_Text_idl="not read")
    assert members() == ["a", "b"]
