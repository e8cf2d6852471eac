"""Sources in UTF-8, Shift_JIS and EUC-JP, with each kind of line end: the results are the same."""

from __future__ import annotations

import codecs
import json
from pathlib import Path

import pytest

from rtgen import api
from rtgen.cli import run
from rtgen.compiler.frontends.kit import character_rules
from rtgen.compiler.project import load
from rtgen.compiler.project.kinds import is_definition

ENCODINGS = {"utf-8": "utf8", "cp932": "sjis", "euc_jp": "euc"}

IDL = """\
/** 腕の姿勢と表示 */
module lab {
  // 手先の位置と機能
  struct Pose {
    double x;   // X座標の表
    double y;   // Y座標
    double z;   // ﾓｰﾀｰの予
    double a; /*\u3000角度のソ */
  };
  const string TITLE = "対応表";
  @rtc(category = "robot", vendor = "産業技術", description = "腕の制御ソフト")
  component Arm {
    @name("pose") publishes Pose pose;
    @default(1.0) @unit("m/s") attribute double speed; // 速度の能
    @default("表") attribute string label;             // 名前の十
  };
};
"""
HEADER = """\
/* 位置の表 */
typedef struct {
  int32_t x;  // X座標の表
  int32_t y;  // Y座標の十
} Place;
"""
CDL = """\
import_C("place.h");
// 位置を調べる機能
signature sPlace {
  ER find([in] const Place *place);   // 現在の位置の表
  ER stop(void);                      /* 停止 */
};
celltype tPlace { entry sPlace ePlace; attr { char_t *name = "対応表"; }; };
[active] celltype tUser { call sPlace cPlace; };
cell tPlace Place0 { };
cell tUser User { [through(RTCPlugin, "")] cPlace = Place0.ePlace; };
"""
EDS = """\
[FileInfo]
FileName=drive.eds
Description=モータ制御の表
[DeviceInfo]
VendorName=産業技術
VendorNumber=1
ProductName=ﾓｰﾀｰの能
[MandatoryObjects]
SupportedObjects=2
1=0x1000
2=0x1001
[OptionalObjects]
SupportedObjects=0
[ManufacturerObjects]
SupportedObjects=1
1=0x2000
[1000]
ParameterName=機器の種類
ObjectType=0x7
DataType=0x0007
AccessType=ro
DefaultValue=0
PDOMapping=0
[1001]
ParameterName=エラーの表
ObjectType=0x7
DataType=0x0005
AccessType=ro
PDOMapping=0
[2000]
ParameterName=速度の十
ObjectType=0x7
DataType=0x0004
AccessType=rw
PDOMapping=0
"""
BUS = """\
# 台車の表
[bus]
bit_rate = 500
[device.drive]
eds = "drive.eds"
[node.left]
device = "drive"   # 左の車輪の予
id = 1
"""
MSG = """\
# 速度の表
float64 x   # X方向の十
"""
PROJECT = """\
# 設定の表
[sources]
paths = ["lab", "lab.idl", "board.cdl", "net.toml", "arm.yaml"]
"""
PROFILE = """\
rtcProfile:
  id: RTC:技術:robot:Hand:1.0.0
  version: '0.2'
  basicInfo:
    name: Hand
    category: robot
    vendor: 産業技術
    version: 1.0.0
    description: 手の制御の表
    moduleType: ''
"""
SOURCES = {
    "lab.idl": IDL,
    "place.h": HEADER,
    "board.cdl": CDL,
    "drive.eds": EDS,
    "net.toml": BUS,
    "lab/msg/Speed.msg": MSG,
    "arm.yaml": PROFILE,
    "rtgen.toml": PROJECT,
}


def write(folder: Path, encoding: str, end: str = "\n", setting: str = "") -> None:
    for name, text in SOURCES.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        if name == "rtgen.toml":
            text += setting
        path.write_bytes(text.replace("\n", end).encode(encoding))


def generated(folder: Path, *arguments: str) -> dict[str, object]:
    """Return what is generated, by path."""
    assert run(["generate", "--no-cache", "-q", *arguments]) == 0
    found: dict[str, object] = {}
    for root in ("generated", "src"):
        for path in (folder / root).rglob("*"):
            if path.is_file():
                found[path.relative_to(folder).as_posix()] = path.read_bytes()
    manifest = json.loads((folder / "generated/.rtgen.json").read_bytes())
    del manifest["inputs"]
    return found | {"generated/.rtgen.json": manifest}


@pytest.fixture(scope="module")
def expected(tmp_path_factory: pytest.TempPathFactory) -> dict[str, dict[str, object]]:
    """What is generated from the sources in UTF-8, by target."""
    found = {}
    with pytest.MonkeyPatch.context() as patch:
        for target in ("embedded", "openrtm"):
            folder = tmp_path_factory.mktemp("utf8")
            patch.chdir(folder)
            write(folder, "utf-8")
            found[target] = generated(folder, "--target", target)
    return found


@pytest.mark.sampled(1)
@pytest.mark.parametrize(
    ("encoding", "end", "how", "target"),
    [
        ("utf-8", "\r\n", "guessed", "embedded"),
        ("cp932", "\n", "guessed", "embedded"),
        ("cp932", "\r\n", "asked", "embedded"),
        ("cp932", "\n", "set", "embedded"),
        ("cp932", "\r\n", "guessed", "openrtm"),
        ("euc_jp", "\r\n", "guessed", "embedded"),
        ("euc_jp", "\n", "asked", "embedded"),
        ("euc_jp", "\r\n", "set", "embedded"),
        ("euc_jp", "\n", "guessed", "openrtm"),
    ],
)
def test_each_encoding_gives_the_same_files(
    encoding: str,
    end: str,
    how: str,
    target: str,
    expected: dict[str, dict[str, object]],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    name = ENCODINGS[encoding]
    write(tmp_path, encoding, end, f'encoding = "{name}"\n' if how == "set" else "")
    asked = ["--kcode", name] if how == "asked" else []
    found = generated(tmp_path, "--target", target, *asked)
    assert found.keys() == expected[target].keys()
    for path, content in found.items():
        assert content == expected[target][path], path
    text = "\n".join(
        content.decode() for content in found.values() if isinstance(content, bytes)
    )
    for part in ("X座標の表", "Y座標", "ﾓｰﾀｰの予", "対応表", "位置を調べる機能"):
        assert part in text


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
@pytest.mark.parametrize("codec", ["utf-8", "utf-8-sig", "utf-16", "cp932"])
@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("net.toml", "[bus]\nbit_rate = 500\n"),
        ("hand.yaml", PROFILE),
        ("pair.yaml", "rtsProfile:\n  id: 系\n"),
        ("pair.xml", '<rts:RtsProfile xmlns:rts="x" rts:abstract="系"/>\n'),
    ],
)
def test_kinds_of_files(
    name: str, text: str, codec: str, end: str, tmp_path: Path
) -> None:
    """What a file is is known in each encoding."""
    path = tmp_path / name
    path.write_bytes(text.replace("\n", end).encode(codec))
    assert is_definition(path)


@pytest.mark.parametrize("mark", [codecs.BOM_UTF8, codecs.BOM_UTF16_LE])
def test_byte_order_marks(
    mark: bytes, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    write(tmp_path, "utf-8")
    plain = generated(tmp_path, "--target", "embedded")
    codec = "utf-8" if mark == codecs.BOM_UTF8 else "utf-16-le"
    for name in SOURCES:
        path = tmp_path / name
        path.write_bytes(mark + path.read_text("utf-8").encode(codec))
    assert generated(tmp_path, "--target", "embedded") == plain


@pytest.mark.parametrize("encoding", ["cp932", "euc_jp"])
def test_formats_in_utf_8_are_read_with_a_warning(
    encoding: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    write(tmp_path, encoding)
    project = load()
    [doubt] = project.problems
    assert doubt.span is not None
    assert (doubt.code, doubt.span.line) == (character_rules.ENCODING.code, 1)
    found = api.read([str(path) for path in project.sources]).diagnostics
    doubted = {
        d.span.file for d in found if d.span and d.code == character_rules.ENCODING.code
    }
    assert doubted == {"lab/msg/Speed.msg", "net.toml", "arm.yaml", "rtgen.toml"}


def test_a_shift_jis_file_says_what_other_programs_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A finding for each comment and literal that ends in the octet of a backslash."""
    monkeypatch.chdir(tmp_path)
    write(tmp_path, "cp932")
    found = api.read(["lab.idl", "board.cdl"]).diagnostics
    places = {
        (d.code, d.span.file, d.span.line)
        for d in found
        if d.span and d.code.startswith("TXT")
    }
    comment, literal = (
        character_rules.OCTET_OF_COMMENT.code,
        character_rules.OCTET_OF_LITERAL.code,
    )
    lines = {
        (comment, "lab.idl"): (3, 5, 7, 14, 15),
        (literal, "lab.idl"): (10, 11, 15),
        (comment, "board.cdl"): (2, 4),
        (literal, "board.cdl"): (7,),
        (comment, "place.h"): (3, 4),
    }
    assert places == {
        (*key, line)
        for key, numbers in lines.items()
        for line in numbers
        if key[1] != "rtgen.toml"
    } | {(character_rules.ENCODING.code, "rtgen.toml", 1)}
    write(tmp_path, "euc_jp")
    again = api.read(["lab.idl", "board.cdl"]).diagnostics
    assert {d.code for d in again if d.code.startswith("TXT")} == {
        character_rules.ENCODING.code
    }


@pytest.mark.parametrize("encoding", ENCODINGS)
def test_convert(
    encoding: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("hand.yaml").write_bytes(PROFILE.encode(encoding))
    assert run(["convert", "hand.yaml", "--to", "rtc-xml", "-q"]) == 0
    xml = capfd.readouterr().out
    assert 'vendor="産業技術"' in xml
    assert 'description="手の制御の表"' in xml


LONE = {
    "a.idl": "struct P {\r  double x; // in m\r  double y;\r};\r",
    "a.cdl": 'import_C("a.h");\rsignature sP { // one\r  ER get(void);\r};\r',
    "a.h": "typedef int ER; // one\rtypedef struct { int x; // two\r int y; } Q;\r",
}


@pytest.mark.parametrize("name", ["a.idl", "a.cdl"])
@pytest.mark.parametrize("mixed", [False, True])
def test_a_lone_carriage_return_is_a_line_end(
    name: str, mixed: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    for file, text in LONE.items():
        Path(file).write_bytes(text.replace("\r", "\n").encode())
    plain = api.read([name])
    assert not [d for d in plain.diagnostics if d.code.startswith("TXT")]
    for file, text in LONE.items():
        made = text.replace("\r", "\n", 1) if mixed else text
        Path(file).write_bytes(made.encode())
    found = api.read([name])
    assert found.model.declarations == plain.model.declarations
    assert [unit.declarations for unit in found.model.tecs] == [
        unit.declarations for unit in plain.model.tecs
    ]
    reported = {
        d.span.file for d in found.diagnostics if d.span and d.code == "TXT0004"
    }
    assert reported == ({"a.idl"} if name == "a.idl" else {"a.cdl", "a.h"})


def test_a_backslash_continues_a_comment_of_idl_and_of_c(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As to omniidl and gcc; CDL has no continued lines, as to tecsgen."""
    monkeypatch.chdir(tmp_path)
    lost = "int x; // 表\\\n int y; // \\\n\n int z;"
    Path("a.idl").write_text(f"struct P {{ {lost.replace('int', 'long')} }};")
    Path("a.h").write_text(f"typedef struct {{ {lost} int w; // 能\\ \n int v;\n}} Q;")
    Path("a.cdl").write_text(
        'import_C("a.h");\nsignature sQ { void f([in] int32_t a); // \\\n'
        " void g([in] const Q *b); };\n"
    )
    found = api.read(["a.idl", "a.cdl"])
    [struct] = found.model.declarations
    assert [member.name for member in struct.members] == ["x", "z"]  # type: ignore[union-attr]
    [unit] = found.model.tecs
    functions = [f.name for d in unit.declarations for f in getattr(d, "functions", ())]
    assert functions == ["f", "g"]
    members = [m.name for d in unit.declarations for m in getattr(d, "members", ())]
    assert members == ["x", "z", "w"]
    noted = [d.span for d in found.diagnostics if d.code == "TXT0003"]
    assert [(s.file, s.line, s.column) for s in noted if s] == [
        ("a.h", 1, 29),
        ("a.h", 4, 20),
        ("a.idl", 1, 24),
    ]
