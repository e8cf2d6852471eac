"""The generated files of one join: black's form, profiles, scripts, the plug-in for tecsgen."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import black
import pytest
from boards import MOTOR, SERVER, emit, imported, joined, texts, write
from lxml import etree
from type_checkers import check_by_mypy

from rtgen.compiler.frontends import cdl, idl
from rtgen.compiler.lowering.tecs.communication import communication_model
from rtgen.compiler.lowering.tecs.idl_model import idl_side
from rtgen.compiler.lowering.tecs.plan import packages
from rtgen.compiler.model import Interface, Struct

ROOT = Path(__file__).parents[3]
RUBY = shutil.which("ruby")
SH = shutil.which("sh")

FILES = {
    "server.cdl": joined(SERVER, "sServer"),
    "board.cdl": joined(MOTOR, "nBoard::sMotor", options="tdr=little, reply=paper"),
    "anys.cdl": joined(MOTOR, "nBoard::sMotor", options="array=any"),
}


@pytest.fixture(scope="module")
def tree(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("tree")
    emission, _ = emit(folder, FILES)
    write(folder, emission.artifacts)
    return folder


@pytest.mark.peer
def test_python_is_in_blacks_form(tree: Path) -> None:
    found = sorted(tree.rglob("*.py"))
    assert len(found) > 20
    for file in found:
        text = file.read_text(encoding="utf-8")
        assert black.format_str(text, mode=black.Mode()) == text, file


@pytest.mark.slow
def test_python_is_typed(tree: Path) -> None:
    check_by_mypy([tree / "robots"], [tree])


def test_profiles_are_xml(tree: Path) -> None:
    profiles = sorted((tree / "robots" / "tecs").rglob("*.xml"))
    assert len(profiles) == 3
    for file in profiles:
        etree.parse(file)
    client = (tree / "robots" / "tecs" / "server" / "RTC.xml").read_text(
        encoding="utf-8"
    )
    assert client.count("<rtc:ServiceInterface ") == 1
    assert 'rtc:direction="Required"' in client
    assert 'rtc:idlFile="Server.idl" rtc:type="Server"' in client


def test_text_depends_on_nothing_else(tree: Path, tmp_path: Path) -> None:
    emission, _ = emit(tmp_path, FILES)
    for path, text in texts(emission.artifacts).items():
        assert (tree / path).read_text(encoding="utf-8") == text
        assert str(tmp_path) not in text
        assert not text or text.endswith("\n")


def test_the_idl_says_what_the_model_says(tree: Path) -> None:
    read = cdl.load([tree / "board.cdl"], root=tree)
    (package,), _ = packages(read.model)
    side, findings = idl_side(package, communication_model(package.sources))
    assert not findings
    again = idl.load(
        [tree / "robots" / "tecs" / "board" / "Motor.idl"], root=tree
    ).model
    names = {d.name for d in again.declarations}
    assert names == {d.name for d in side.services[0].declarations}
    for declaration in side.services[0].declarations:
        found = again.find(declaration.name)
        assert type(found) is type(declaration)
        if isinstance(declaration, Interface):
            assert isinstance(found, Interface)
            pairs = zip(declaration.operations, found.operations, strict=True)
            for ours, theirs in pairs:
                assert ours.name == theirs.name
                assert ours.returns == theirs.returns
                assert [(p.direction, p.name, p.type) for p in ours.parameters] == [
                    (p.direction, p.name, p.type) for p in theirs.parameters
                ]
        if isinstance(declaration, Struct):
            assert isinstance(found, Struct)
            assert [(m.name, m.type) for m in declaration.members] == [
                (m.name, m.type) for m in found.members
            ]


@pytest.mark.skipif(SH is None, reason="sh is missing")
def test_the_build_script(tree: Path, tmp_path: Path) -> None:
    assert SH is not None
    emission, _ = emit(tmp_path, {"server.cdl": FILES["server.cdl"]}, corba=True)
    write(tmp_path, emission.artifacts)
    package = tmp_path / "robots" / "tecs" / "server"
    assert (package / "build.bat").is_file()
    assert not list(tree.rglob("build.*")), "there is no IDL to compile without CORBA"
    script = package / "build.sh"
    subprocess.run([SH, "-n", str(script)], check=True)
    run = subprocess.run(
        [SH, str(script)],
        cwd=tmp_path,
        env={
            "PYTHON": sys.executable,
            "STUBS": str(tmp_path / "stubs"),
            "PATH": f"{Path(sys.executable).parent}:/usr/bin:/bin",
            "PYTHONDONTWRITEBYTECODE": "1",
            "PYTHONPATH": str(ROOT / "src"),
        },
        capture_output=True,
        text=True,
        check=False,
    )
    assert run.returncode == 0, run.stderr
    assert run.stdout.endswith("tecs.server: ready\n")
    if "omniidl is missing" not in run.stderr:
        assert (tmp_path / "stubs" / "Server_idl.py").exists()


STUB = """
Named = Struct.new(:get_namespace_path)
Path = Struct.new(:get_path_str)
Call = Struct.new(:get_name, :get_subscript)
class OpaqueRPCPlugin
  attr_reader :seen
  def initialize(arguments, need)
    @seen = {}
    @PPAllocatorSize = nil
    @through_type = :THROUGH
    @caller_cell = Named.new(Path.new("::Client0"))
    @join = Call.new(:cServer, nil)
    @signature = Named.new(Path.new("::sServer"))
    @signature.define_singleton_method(:need_PPAllocator?) { |_| need }
    arguments.each { |name, value| check_plugin_arg(name.to_sym, value) }
    check_PPAllocator
    @seen["PPAllocatorSize"] = @PPAllocatorSize
  end
  def check_plugin_arg(ident, rhs)
    raise "P1004 #{ident}" unless %w[taskPriority PPAllocatorSize].include?(ident.to_s)
    ident == :PPAllocatorSize ? @PPAllocatorSize = rhs : @seen[ident.to_s] = rhs
  end
  def check_PPAllocator
    raise "no PPAllocatorSize" if @PPAllocatorSize.nil? && @signature.need_PPAllocator?(true)
  end
  def cdl_error(text) = @seen["error"] = text
  def subst_name(text) = text.sub("$count$", "0")
  def set_TDRCelltype(value) = @seen["TDRCelltype"] = value
  def set_clientChannelInitializer(value) = @seen["client"] = value
  def set_serverChannelInitializer(value) = @seen["server"] = value
end
def require_tecsgen_lib(name) = name
load ARGV[0]
class RTCPlugin
  def rtc_digest = DIGESTS.fetch("sServer")
end
need, *arguments = ARGV.drop(1)
puts RTCPlugin.new(arguments.map { |a| a.split("=", 2) }, need == "true").seen.inspect
"""
"""The part of tecsgen that the plug-in uses; it prints its arguments."""


def _board(port: int = 8931, address: str = "127.0.0.1", **more: str) -> dict[str, str]:
    return {
        "server": f"portNo={port};",
        "client": f'portNo={port}; serverAddr=\\"{address}\\"; ',
        "PPAllocatorSize": "4096",
        **more,
    }


@pytest.mark.sampled(3)
@pytest.mark.skipif(RUBY is None, reason="ruby is missing")
@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        ((), _board()),
        (("timeout=2", "name=Left", "longBits=32"), _board()),
        (("PPAllocatorSize=99",), _board(PPAllocatorSize="99")),
        (("taskPriority=3",), _board(taskPriority="3")),
        (("tdr=network",), _board()),
        (("tdr=little", "longBits=64"), _board(TDRCelltype="tTDR")),
        (("port=40000",), _board(port=-25536)),
        (("port=9000 + $count$",), _board(port=9000)),
        (("address=10.0.0.7",), _board(address="10.0.0.7")),
        (
            ("reply=paper",),
            _board(
                error="R1001 RTCPlugin: reply=paper cannot be honoured: "
                "tecsgen's boards send the return value first"
            ),
        ),
        (
            ("longBits=64",),
            _board(
                error="R1001 RTCPlugin: longBits=64 cannot be honoured: "
                "the board sends 32 bits in the network's order"
            ),
        ),
    ],
)
def test_the_plug_in_for_tecsgen(
    tree: Path, tmp_path: Path, arguments: tuple[str, ...], expected: dict[str, str]
) -> None:
    assert RUBY is not None
    plugin = tree / "robots" / "tecs" / "server" / "RTCPlugin.rb"
    subprocess.run([RUBY, "-c", str(plugin)], check=True, capture_output=True)
    stub = tmp_path / "stub.rb"
    stub.write_text(STUB, encoding="utf-8")
    command = [RUBY, str(stub), str(plugin), "true", *arguments]
    run = subprocess.run(command, capture_output=True, text=True, check=True)
    for name, value in expected.items():
        assert f'"{name}"=>"{value}"' in run.stdout.replace(" => ", "=>")
    assert run.stdout.count('"=>') == len(expected)


@pytest.mark.skipif(RUBY is None, reason="ruby is missing")
def test_no_allocator_where_none_is_needed(tree: Path, tmp_path: Path) -> None:
    assert RUBY is not None
    stub = tmp_path / "stub.rb"
    stub.write_text(STUB, encoding="utf-8")
    plugin = str(tree / "robots" / "tecs" / "server" / "RTCPlugin.rb")
    run = subprocess.run(
        [RUBY, str(stub), plugin, "false"], capture_output=True, text=True, check=True
    )
    assert '"PPAllocatorSize"=>nil' in run.stdout.replace(" => ", "=>")


@pytest.mark.parametrize(
    "name", ["OpaqueRpc", "ThingMarshaller", "thingclient", "abstractmethod"]
)
def test_names_of_what_every_board_has(tmp_path: Path, name: str) -> None:
    """A constant of such a name once replaced the interface of the line."""
    text = f"""
        const int32_t {name} = 3;
        signature sThing {{ ER abstractmethod( [in] int32_t a ); ER property( void ); }};
    """
    emission, findings = emit(tmp_path, {"a.cdl": joined(text, "sThing")})
    assert not findings
    write(tmp_path, emission.artifacts)
    with imported(
        tmp_path, "robots.tecs.a.thing_server", "robots.tecs.a.thing_marshaller"
    ) as made:
        assert made[0].ThingTarget.__abstractmethods__ == {
            "abstractmethod_",
            "property",
        }
        assert made[1].ThingMarshaller.profile.type_name == "ThingMarshaller"


def test_the_plug_in_of_a_file_knows_the_joins_of_main_files_that_it_imports(
    tmp_path: Path,
) -> None:
    part = joined("signature sPart { ER f( void ); };", "sPart")
    whole = 'import( "part.cdl" );\n' + joined(
        "signature sWhole { ER f( void ); };", "sWhole"
    ).replace("tServer0", "tOther").replace("tClient0", "tCaller").replace(
        "Server0", "Other"
    ).replace(
        "Client0", "Caller"
    )
    emission, _ = emit(tmp_path, {"part.cdl": part, "whole.cdl": whole})
    made = texts(emission.artifacts)
    plugin = made["robots/tecs/whole/RTCPlugin.rb"]
    assert "'Caller.cServer' => 8931" in plugin
    assert "'Client0.cServer' => 8931" in plugin
    assert "'sPart' => '" in plugin
    assert "Caller" not in made["robots/tecs/part/RTCPlugin.rb"]


@pytest.mark.parametrize(
    ("name", "made"),
    [("lazy_names", "lazy_names"), ("TYPE_CHECKING", "TYPE_CHECKING_")],
)
def test_a_signature_is_called_as_what_its_package_imports(
    name: str, made: str, tmp_path: Path
) -> None:
    text = joined(SERVER.replace("sServer", name), name)
    emission, _ = emit(tmp_path, {"server.cdl": text})
    write(tmp_path, emission.artifacts)
    program = f"from robots.tecs.server import {made}; print({made}._descriptor_.name)"
    command = [sys.executable, "-c", program]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
    assert done.stdout.strip().endswith(name), done.stderr
