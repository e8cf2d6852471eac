"""One CDL file in rtgen and tecsgen: ports, function ids and digests agree.

tecsgen 1.7 is named by RTGEN_TECSGEN, or found on the path.
"""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

import pytest
from programs import TECSGEN, needs_tecsgen

from rtgen.compiler.backends import Options
from rtgen.compiler.backends.tecs.backend import BACKEND
from rtgen.compiler.diagnostics import has_errors
from rtgen.compiler.frontends.cdl import load
from rtgen.compiler.layouts.signature_digest import signature_digest, signature_text
from rtgen.compiler.lowering.settings import Settings
from rtgen.compiler.lowering.stage import lowered
from rtgen.compiler.model import Model
from rtgen.compiler.model.tecs import Signature, TecsUnit

FOLDER = Path(__file__).parent / "tecs_lines"
BOARD = (FOLDER / "board.cdl").read_text(encoding="utf-8")
PORTS = {
    "RTCPlugin__0": 8931,
    "RTCPlugin__1": 8932,
    "RTCPlugin__2": 9000,
    "Join_to_through___0": 8934,
}
"""The cells that tecsgen makes for the joins, and the ports of both halves."""


def _model(folder: Path, text: str = BOARD) -> Model:
    """Return the model of a CDL file."""
    file = folder / "board.cdl"
    file.write_text(text, encoding="utf-8")
    read = load([file], root=folder, include=[FOLDER])
    assert not has_errors(read.diagnostics), read.diagnostics
    return read.model


def _digests(folder: Path, text: str) -> list[str]:
    """Return the digests of both signatures."""
    (unit,) = _model(folder, text).tecs
    return [signature_digest(unit, _signature(unit, n)) for n in ("sMotor", "sLamp")]


def _generate(folder: Path, text: str = BOARD) -> tuple[TecsUnit, dict[str, str]]:
    """Return the unit of a CDL file, and rtgen's output by the names of the files."""
    model = _model(folder, text)
    made = lowered(model, Settings())
    assert not has_errors(made.diagnostics), made.diagnostics
    emission = BACKEND.emit(made.model, Options("robots", "nodes", "0.1.0"))
    assert not has_errors(emission.diagnostics), emission.diagnostics
    return model.tecs[0], {
        Path(artifact.path).name: artifact.text
        for artifact in emission.artifacts
        if artifact.path.startswith("robots/tecs/board/")
    }


def _tecsgen(folder: Path, plugin: str, text: str = BOARD) -> tuple[int, str]:
    """Return exit code and messages of tecsgen, whose files are in `gen`."""
    assert TECSGEN is not None
    (folder / "RTCPlugin.rb").write_text(plugin, encoding="utf-8")
    (folder / "board.cdl").write_text(text, encoding="utf-8")
    command = [TECSGEN, "-L", ".", "-I", str(FOLDER), "-g", "gen", "board.cdl"]
    run = subprocess.run(
        command,
        cwd=folder,
        capture_output=True,
        encoding="utf-8",
        errors="replace",
        check=False,
    )
    return run.returncode, run.stdout + run.stderr


def _signature(unit: TecsUnit, name: str) -> Signature:
    found = unit.find((name,), Signature)
    assert isinstance(found, Signature)
    return found


def test_ports_of_joins_without_options_count_up(tmp_path: Path) -> None:
    _, made = _generate(tmp_path)
    confs = [text for name, text in made.items() if name.endswith(".conf")]
    ports = [re.search(r"mode2\.port: (\d+)", text) for text in confs]
    assert sorted(int(p[1]) for p in ports if p) == sorted(PORTS.values())


def test_the_digest_is_one_of_functions_parameters_and_types(tmp_path: Path) -> None:
    unit, made = _generate(tmp_path)
    lamp = _signature(unit, "sLamp")
    assert signature_text(unit, lamp) == (
        "1 error int dim(in uint8_t percent,out *uint8_t before)\n"
        "2 oneway error int off()\n"
    )
    lines = signature_text(unit, _signature(unit, "sMotor")).splitlines()
    assert lines[1] == (
        "2 error int drive(in *double64_t speed size_is=count max=2,in int32_t count,"
        "in uint8_t percent,out *struct 1{[8]char_t label;[2]double64_t speed;"
        "[2][3]uint8_t grid;struct 2{int16_t x;int32_t y;} at;"
        "*int8_t data size_is=count;int8_t count;bool_t stopped;} state)"
    )
    assert lines[2].startswith("3 error int follow(in *struct 2 points size_is=n,")
    digest = signature_digest(unit, lamp)
    assert re.fullmatch("[0-9a-f]{16}", digest)
    assert f'digest: ClassVar[str] = "{digest}"' in made["lamp_codec.py"]
    assert f"'sLamp' => '{digest}'" in made["RTCPlugin.rb"]


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("[in] schar_t sign", "[in] char_t sign"),
        ("[in] char_t letter, [in] schar_t sign", "[in] schar_t sign, [in] char_t letter"),
        ("ER_INT dim", "ER_INT brighten"),
        ("ER_INT dim", "int_t dim"),
        ("int16_t x;\n    int32_t y;", "int32_t y;\n    int16_t x;"),
        ("count, WHEELS", "count, 3"),
        ("const uint8_t grid[2][3], [in]", "const uint8_t grid[3][2], [in]"),
        ("[in, nullable]", "[in]"),
        ("string( 32 )", "string( 33 )"),
        ("[oneway] ER off", "ER off"),
    ],
)  # fmt: skip
def test_a_signature_that_differs_has_another_digest(
    tmp_path: Path, before: str, after: str
) -> None:
    assert _digests(tmp_path, BOARD) != _digests(tmp_path, BOARD.replace(before, after))


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("typedef uint8_t Percent;", "typedef uint8_t Level;\ntypedef Level Percent;"),
        ("tagPoint", "tagPlace"),
        ("[out] Percent *before", "[out] uint8_t *before"),
        ("string( 32 )", "string( WHEELS * 16 )"),
        ("[in] Point", "[in] struct tagPoint"),
    ],
)
def test_another_spelling_of_a_signature_has_the_same_digest(
    tmp_path: Path, before: str, after: str
) -> None:
    assert _digests(tmp_path, BOARD) == _digests(tmp_path, BOARD.replace(before, after))


@needs_tecsgen
@pytest.mark.parametrize("subscripts", [("[0]", "[1]"), ("[]", "[]")])
def test_both_halves_of_a_file_agree(
    tmp_path: Path, subscripts: tuple[str, str]
) -> None:
    text = BOARD
    for number, subscript in enumerate(subscripts):
        text = text.replace(f"cLamp[{number}] =", f"cLamp{subscript} =")
    unit, made = _generate(tmp_path, text)
    code, messages = _tecsgen(tmp_path, made["RTCPlugin.rb"], text)
    assert code == 0, messages
    gen = tmp_path / "gen"
    cdl = "".join(
        p.read_text(errors="replace") for p in gen.glob("tmp_RTCPlugin_*.cdl")
    )
    for side in ("Client", "Server"):
        cells = re.findall(rf"cell tSocket{side} (\w+){side}\{{\s*portNo=(\d+);", cdl)
        assert {name: int(port) for name, port in cells} == PORTS
    for signature in ("sMotor", "sLamp"):
        ours = _signature(unit, signature)
        server = (gen / "rBoard" / f"tOpaqueUnmarshaler_{signature}.c").read_text(
            encoding="utf-8", errors="replace"
        )
        expected = f'{signature}_digest[] = "{signature_digest(unit, ours)}"'
        assert expected in server
        answer = f"cTDR_putUInt64(UINT64_C(0x{signature_digest(unit, ours)}))"
        assert answer in server[server.index("case 0x7FFF:") :]
        header = (gen / "rBoard" / f"{signature}_tecsgen.h").read_text(errors="replace")
        ids = re.findall(
            rf"#define\s+FUNCID_{signature.upper()}_(\w+)\s+\((\d+)\)", header
        )
        assert ids == [(f.name.upper(), str(f.id)) for f in ours.functions]


@needs_tecsgen
@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("[in] char_t letter, [in] schar_t sign", "[in] schar_t sign, [in] char_t letter"),
        ("[out] Percent *before", "[out] int8_t *before"),
    ],
)  # fmt: skip
def test_a_board_of_another_signature_is_refused(
    tmp_path: Path, before: str, after: str
) -> None:
    _, made = _generate(tmp_path)
    changed = BOARD.replace(before, after)
    code, messages = _tecsgen(tmp_path, made["RTCPlugin.rb"], changed)
    assert code == 1
    assert "error: R1002 RTCPlugin" in messages


@needs_tecsgen
def test_a_board_with_another_join_is_refused(tmp_path: Path) -> None:
    _, made = _generate(tmp_path)
    changed = BOARD.replace("cLamp", "cLight")
    code, messages = _tecsgen(tmp_path, made["RTCPlugin.rb"], changed)
    assert code == 1
    assert (
        "R1003 RTCPlugin: the robot's half has no join rBase::Base.cLight[0]"
        in messages
    )


@needs_tecsgen
@pytest.mark.parametrize(
    ("options", "refused"),
    [
        ("reply = paper", "reply=paper"),
        ("longBits = 64", "longBits=64"),
        ("shortBits = 32", "shortBits=32"),
        ("device = /dev/ttyS0", "device"),
        ("tdr = little, longBits = 64", None),
        ("reply = tecsgen, longBits = 32, encoding = utf-8", None),
    ],
)
def test_options_that_tecsgen_cannot_honour_are_errors(
    tmp_path: Path, options: str, refused: str | None
) -> None:
    text = re.sub(r'RTCPlugin, "[^"]*"', f'RTCPlugin, "{options}"', BOARD)
    _, made = _generate(tmp_path, text)
    code, messages = _tecsgen(tmp_path, made["RTCPlugin.rb"], text)
    assert code == (0 if refused is None else 1), messages
    if refused is not None:
        assert f"R1001 RTCPlugin: {refused} cannot be honoured" in messages
