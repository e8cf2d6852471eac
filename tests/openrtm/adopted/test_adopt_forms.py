"""Modules that `rtgen adopt` reads: encodings, Python 2, bases and IDL of the same repository."""

from __future__ import annotations

import ast
import sys
from pathlib import Path

import pytest

from rtgen.cli import run
from rtgen.compiler.diagnostics import Span
from rtgen.openrtm import python_modules
from rtgen.openrtm.python_modules import rules
from rtgen.openrtm.python_modules.source import read_source

MODULE = """\
import OpenRTM_aist
import RTC
{imports}
spec = ["implementation_id", "Part", "type_name", "Part", "description", "{text}", ""]
class Part({base}):
    {body}
"""
BODY = """\
def onInitialize(self):
        self._in = OpenRTM_aist.InPort("in", RTC.TimedLong(RTC.Time(0, 0), 0))
        self.addInPort("in", self._in)
"""
OWN = "OpenRTM_aist.DataFlowComponentBase"


def module(
    imports: str = "", base: str = OWN, body: str = BODY, text: str = "x"
) -> str:
    return MODULE.format(imports=imports, base=base, body=body, text=text)


def codes(result: python_modules.ModuleResult) -> list[str]:
    return [d.code for d in result.diagnostics]


@pytest.mark.parametrize(
    ("declared", "encoding", "reported"),
    [
        ("euc-jp", "euc_jp", []),
        ("shift_jis", "cp932", []),
        ("utf-8", "utf-8-sig", []),
        ("", "euc_jp", [rules.ASSUMED.code]),
        ("", "cp932", [rules.ASSUMED.code]),
        ("utf-8", "cp932", [rules.ASSUMED.code]),
        ("utf-8", "euc_jp", [rules.ASSUMED.code]),
        ("", "utf-16", [rules.ASSUMED.code]),
        ("rot13", "utf-8", [rules.ASSUMED.code]),
        ("no-such-code", "utf-8", [rules.ASSUMED.code]),
    ],
)
def test_encodings(
    declared: str, encoding: str, reported: list[str], tmp_path: Path
) -> None:
    path = tmp_path / "a.py"
    line = f"# coding: {declared}\n" if declared else ""
    path.write_bytes((line + module(text="距離センサ")).encode(encoding))
    result = python_modules.read(path)
    assert result.profile is not None
    assert result.profile.description == "距離センサ"
    assert [port.name for port in result.profile.data_ports] == ["in"]
    assert codes(result) == reported


def test_modules_of_python_2_one_after_another(tmp_path: Path) -> None:
    path = tmp_path / "a.py"
    for end, code in (
        ('print "x"\n', rules.ASSUMED.code),
        ('print "x\n', rules.UNREADABLE.code),
        (
            "try:\n    exec `1`\nexcept KeyError, e:\n    raise e, None\n",
            rules.ASSUMED.code,
        ),
        ("print (\n", rules.UNREADABLE.code),
        ('print "x"\n', rules.ASSUMED.code),
    ):
        path.write_text(module() + end)
        assert codes(python_modules.read(path)) == [code], end


def test_python_2_without_its_converter(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "fissix.refactor", None)
    path = tmp_path / "a.py"
    path.write_text(module() + 'print "x"\n')
    (found,) = python_modules.read(path).diagnostics
    assert found.code == rules.UNREADABLE.code
    assert found.span is not None
    assert found.span.line == 10
    assert ".[python2]" in (found.hint or "")


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a repository with a component in a folder, a base and constants elsewhere."""
    (tmp_path / ".git").mkdir()
    (tmp_path / "common").mkdir()
    (tmp_path / "common/__init__.py").write_text("")
    (tmp_path / "common/base.py").write_text(
        module(body=BODY, base=OWN).replace("class Part", "class Base")
    )
    work = tmp_path / "parts"
    work.mkdir()
    (work / "names.py").write_text('OUT = "out"\nMORE = [OUT + "2"]\n')
    monkeypatch.chdir(work)
    return work


def test_bases_and_constants_of_the_repository(folder: Path) -> None:
    body = """\
def onInitialize(self):
        super().onInitialize()
        for name in (OUT, *names.MORE):
            self.addOutPort(name, OpenRTM_aist.OutPort(name, RTC.TimedLong(None, 0)))
"""
    imports = "from common.base import Base\nimport names\nfrom names import *"
    path = folder / "a.py"
    path.write_text(module(imports, "Base", body))
    result = python_modules.read(path)
    assert result.profile is not None
    ports = [port.name for port in result.profile.data_ports]
    assert ports == ["in", "out", "out2"]
    assert codes(result) == []
    assert len(result.sources) > 1


def test_a_base_that_is_not_called_makes_nothing(folder: Path) -> None:
    path = folder / "a.py"
    body = "def onInitialize(self):\n        return RTC.RTC_OK\n"
    path.write_text(module("from common import base", "base.Base", body))
    result = python_modules.read(path)
    assert result.profile is not None
    assert result.profile.data_ports == ()


def test_a_base_that_is_not_found(tmp_path: Path) -> None:
    path = tmp_path / "a.py"
    path.write_text(module("from elsewhere.base import Base", "Base"))
    (found,) = python_modules.read(path).diagnostics
    assert found.code == rules.NO_COMPONENT.code
    assert "elsewhere.base.Base is not found" in found.message
    assert "-I" in (found.hint or "")
    other = tmp_path / "more/elsewhere"
    other.mkdir(parents=True)
    (other / "base.py").write_text(f"import OpenRTM_aist\nclass Base({OWN}): pass\n")
    assert python_modules.read(path, [tmp_path / "more"]).profile is not None


@pytest.mark.parametrize("place", ["Yard.idl", "idl/Yard.idl", "../idl/Yard.idl"])
def test_idl_beside_the_module(
    place: str, folder: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    file = folder / place
    file.parent.mkdir(exist_ok=True)
    file.write_text("module Yard { struct Load { long mass; }; };\n")
    (file.parent / "Broken.idl").write_text("struct Other {\n")
    body = BODY.replace("RTC.TimedLong(RTC.Time(0, 0), 0)", "Yard.Load(0)")
    path = folder / "a.py"
    path.write_text(module("import Yard", body=body))
    assert run(["adopt", "a.py"]) == 0
    out, err = capfd.readouterr()
    assert '#include "Yard.idl"' in out
    assert "consumes Yard::Load in_;" in out
    assert "RTC0537" not in err


@pytest.mark.sampled(0)
def test_a_module_that_never_ends(tmp_path: Path) -> None:
    body = BODY + "        while True:\n            for i in range(1000): f(i)\n"
    path = tmp_path / "a.py"
    path.write_text(module(body=body))
    result = python_modules.read(path)
    assert result.profile is not None
    assert codes(result) == [rules.COMPUTED.code]


def test_threads_that_parse_at_the_same_time(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    disturbed = iter([True, True, False])
    parse = ast.parse

    def disturbing(text: str, file: str) -> ast.Module:
        if next(disturbed):
            raise SystemError("AST constructor recursion depth mismatch")
        return parse(text, file)

    monkeypatch.setattr(ast, "parse", disturbing)
    path = tmp_path / "a.py"
    path.write_text(module())
    result = python_modules.read(path)
    assert result.profile is not None
    assert codes(result) == []


def test_a_file_that_python_never_parses(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def disturbed(text: str, file: str) -> ast.Module:
        raise SystemError("AST constructor recursion depth mismatch")

    monkeypatch.setattr(ast, "parse", disturbed)
    path = tmp_path / "a.py"
    path.write_text(module())
    result = python_modules.read(path)
    assert result.profile is None
    assert codes(result) == [rules.UNREADABLE.code]


def test_mixed_tabs_are_not_called_python_2(tmp_path: Path) -> None:
    file = tmp_path / "tabs.py"
    file.write_text("def f(a):\n    if a:\n\treturn 1\n    return 2\n")
    (finding,) = read_source(file).diagnostics
    assert finding.message == (
        "tabs and spaces are mixed; a tab is read as eight columns"
    )
    file.write_text("print 'x'\n")
    (finding,) = read_source(file).diagnostics
    assert "this is Python 2" in finding.message


def test_places_of_python_2_are_those_of_the_file(tmp_path: Path) -> None:
    """Its conversion expands tabs, and adds brackets and lines."""
    file = tmp_path / "old.py"
    lines = (
        "def f(a, (b, c)):",
        "\treturn '車輪', b",
        "if f:",
        "\tx = '車輪'; y = 1",
        "        print 'x'",
    )
    file.write_text("\n".join(lines), encoding="utf-8")
    source = read_source(file)
    assert source.text.split("\n") == [*lines]
    (finding,) = source.diagnostics
    assert finding.span == Span(file.as_posix(), 1, 10, 1, 11)
    assert source.tree is not None
    places = {
        node.targets[0].id: (node.lineno, node.col_offset)
        for node in ast.walk(source.tree)
        if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name)
    }
    assert places == {"x": (4, 1), "y": (4, 11)}


@pytest.mark.parametrize(
    ("lines", "marked"),
    [
        (["if a:", "        b = 1", "\tprint 'x'"], (3, 2, 3)),
        (["if a:", "    if b:", "\tc = 1"], (3, 1, 2)),
    ],
)
def test_what_is_marked_in_lines_with_tabs(
    tmp_path: Path, lines: list[str], marked: tuple[int, int, int]
) -> None:
    file = tmp_path / "tabs.py"
    file.write_text("\n".join(lines), encoding="utf-8")
    (finding,) = read_source(file).diagnostics
    line, column, end = marked
    assert finding.span == Span(file.as_posix(), line, column, line, end)


BASE = """\
import OpenRTM_aist
import RTC
class RobotBase(OpenRTM_aist.DataFlowComponentBase):
    def onInitialize(self):
        self._out = OpenRTM_aist.OutPort("out", RTC.TimedLong(RTC.Time(0, 0), 0))
        self.addOutPort("out", self._out)
"""
FROM_HERE = "os.path.dirname(os.path.abspath(__file__))"
ADDING = [
    f'sys.path += [os.path.join({FROM_HERE}, "..", "common")]',
    f'sys.path.append(os.path.join({FROM_HERE}, "../common"))',
    'sys.path.insert(0, os.path.join(os.path.dirname(__file__), "../common"))',
    'sys.path.insert(1, os.path.realpath(os.path.dirname(__file__) + "/../common"))',
    'sys.path.append("../common")',
    'sys.path.extend(["nothing", "../common"])',
    'sys.path = ["../common"] + sys.path',
    "sys.path = sys.path + ['../common']",
    'sys.path.append(str(Path(__file__).resolve().parent.parent / "common"))',
    'sys.path.append(str(Path(__file__).parents[1].joinpath("common")))',
    'sys.path.append(os.fspath(Path(__file__).absolute().parents[1] / "common"))',
    f"HERE = {FROM_HERE}\nCOMMON = os.path.join(HERE, '..', 'common')\nsys.path += [COMMON]",
    'if True:\n    sys.path.append("../common")',
]
UNKNOWN = [
    "",
    'sys.path += [os.environ["ROBOT"]]',
    "sys.path.append(folder())",
    'sys.path.append("../nothing")',
    "A = B\nB = A\nsys.path.append(A)",
    'sys.path.append(Path("x").parents[10**9])',
    'other.path.append("../common")',
]
FORMS = [
    ("from robot_base import RobotBase", "RobotBase", "robot_base.RobotBase"),
    ("from robot_base import RobotBase as Base", "Base", "robot_base.RobotBase"),
    ("import robot_base", "robot_base.RobotBase", "robot_base.RobotBase"),
    ("from robot_base import *", "RobotBase", "RobotBase"),
]
IMPORTS = "import os\nimport sys\nfrom pathlib import Path\n"


def repository(tmp_path: Path, adding: str, imports: str, base: str) -> Path:
    """Write a repository whose component has a base in another folder; return its file."""
    for folder in (".git", "arm", "common"):
        (tmp_path / folder).mkdir()
    (tmp_path / "common/robot_base.py").write_text(BASE)
    file = tmp_path / "arm" / "arm.py"
    file.write_text(module(f"{IMPORTS}{adding}\n{imports}", base, "pass"))
    return file


@pytest.mark.parametrize("adding", ADDING)
def test_a_base_in_a_folder_that_the_module_adds(tmp_path: Path, adding: str) -> None:
    for number, (imports, base, _) in enumerate(FORMS):
        folder = tmp_path / str(number)
        folder.mkdir()
        result = python_modules.read(repository(folder, adding, imports, base))
        assert result.profile is not None, result.diagnostics
        assert [port.name for port in result.profile.data_ports] == ["out"]


@pytest.mark.parametrize("adding", UNKNOWN)
@pytest.mark.parametrize(("imports", "base", "name"), FORMS)
def test_a_base_that_is_not_found_is_named_with_its_file(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    adding: str,
    imports: str,
    base: str,
    name: str,
) -> None:
    file = repository(tmp_path, adding, imports, base)
    (tmp_path / "spare").mkdir()
    (tmp_path / "spare/robot_base.py").write_text(BASE)
    monkeypatch.chdir(tmp_path)
    result = python_modules.read(file.relative_to(tmp_path))
    [finding] = result.diagnostics
    assert finding.code == rules.NO_COMPONENT.code
    assert finding.message == (
        "there is no class that derives from DataFlowComponentBase, "
        f"and {name} is not found"
    )
    assert finding.hint == "common/robot_base.py has it: -I common"
    assert finding.span is not None
    line = file.read_text().splitlines()[finding.span.line - 1]
    assert line[finding.span.column - 1 :].startswith(base)
    found = python_modules.read(file, [tmp_path / "common"])
    assert found.profile is not None


@pytest.mark.parametrize("adding", UNKNOWN)
def test_the_only_file_of_the_repository_with_a_base_is_taken(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, adding: str
) -> None:
    monkeypatch.chdir(tmp_path)
    for number, (imports, base, name) in enumerate(FORMS):
        folder = tmp_path / str(number)
        folder.mkdir()
        file = repository(folder, adding, imports, base).relative_to(tmp_path)
        result = python_modules.read(file)
        assert result.profile is not None, result.diagnostics
        assert [port.name for port in result.profile.data_ports] == ["out"]
        [finding] = result.diagnostics
        assert finding.code == rules.COMPUTED.code
        assert finding.message == (
            f"the folder of {name} is known only when the module runs; "
            f"{number}/common/robot_base.py is taken"
        )


def test_folders_outside_of_the_repository_are_not_read(tmp_path: Path) -> None:
    inside = tmp_path / "repository"
    inside.mkdir()
    outside = tmp_path / "outside"
    outside.mkdir()
    file = repository(inside, f'sys.path.append("{outside}")', *FORMS[0][:2])
    (inside / "common/robot_base.py").rename(outside / "robot_base.py")
    [finding] = python_modules.read(file).diagnostics
    assert finding.hint == "name the folder of the module robot_base with -I"


CONSUMER = """\
def onInitialize(self):
        self._port = OpenRTM_aist.CorbaPort("service")
        self._consumer = OpenRTM_aist.CorbaConsumer(interfaceType=SimpleService.MyService)
        self._port.registerConsumer("myservice0", "{name}", self._consumer)
        self.addPort(self._port)
"""
SERVICE = "module SimpleService { interface MyService { void go(); }; };\n"


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("MyService", '@type_name("MyService")'),
        ("Other", '@type_name("Other")'),
        ("SimpleService::MyService", ""),
    ],
)
def test_the_registered_name_of_a_consumer(
    tmp_path: Path,
    name: str,
    said: str,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("MyService.idl").write_text(SERVICE)
    Path("a.py").write_text(
        module("import SimpleService", body=CONSUMER.format(name=name))
    )
    assert run(["adopt", "a.py"]) == 0
    text = capsys.readouterr().out
    assert "uses SimpleService::MyService myservice0;" in text
    assert ("@type_name" in text) == bool(said)
    assert said in text


@pytest.mark.parametrize(
    "kind", ["DataFlowComponent", "PERIODIC", "EVENTDRIVEN", "STATIC", "UNIQUE", 'a "b']
)
def test_the_activity_type_is_what_the_module_registers(
    kind: str,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    entry = f'"type_name", "Part", "activity_type", {kind!r}'
    Path("a.py").write_text(module().replace('"type_name", "Part"', entry))
    assert run(["adopt", "a.py", "-o", "idl"]) == 0
    text = Path("idl/Part.idl").read_text()
    assert ("activity_type=" in text) == (kind not in ("STATIC", "UNIQUE"))
    assert run(["generate", "idl", "--target", "openrtm", "-o", "out"]) == 0
    capsys.readouterr()
    [made] = Path("out").rglob("Part.py")
    assert registered_texts(made)["activity_type"] == kind
    profile = next(Path("out").rglob("RTC.xml"))
    Path("again").mkdir()
    Path("again/Part.xml").write_text(profile.read_text())
    assert run(["generate", "again", "--target", "openrtm", "-o", "back"]) == 0
    [made] = Path("back").rglob("Part.py")
    assert registered_texts(made)["activity_type"] == kind


def registered_texts(file: Path) -> dict[str, str]:
    """Return the module spec of a generated module."""
    texts: list[list[str]] = [
        [each.value for each in node.elts if isinstance(each, ast.Constant)]  # type: ignore[misc]
        for node in ast.walk(ast.parse(file.read_text()))
        if isinstance(node, ast.List | ast.Tuple)
    ]
    [spec] = [each for each in texts if "implementation_id" in each]
    return dict(zip(spec[::2], spec[1::2], strict=False))


def test_the_name_is_the_type_name(tmp_path: Path) -> None:
    path = tmp_path / "a.py"
    text = module().replace('"type_name", "Part"', '"type_name", "Kind"')
    path.write_text(text)
    result = python_modules.read(path)
    assert result.profile is not None
    assert result.profile.name == "Kind"
    [finding] = result.diagnostics
    assert finding.code == rules.NOT_CARRIED.code
    assert finding.message == "the implementation_id Part is left out"
