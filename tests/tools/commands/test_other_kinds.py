"""Commands with a file of one kind refuse files whose names are of another kind."""

from __future__ import annotations

from pathlib import Path

import pytest

from rtgen.cli import run

SPECS = Path(__file__).parents[3] / "specs"
FILES = {
    "arm.idl": b"module M { struct S { long x; }; };\n",
    "drive.eds": (SPECS / "canopen" / "epos_drive.eds").read_bytes(),
    "lamp.cdl": b"signature sLamp { void off( void ); };\n",
    "editor.cde": b"signature sLamp { void off( void ); };\n",
    "lamp.txt": b"signature sLamp { void off( void ); };\n",
    "system.xml": b"<rts:RtsProfile/>\n",
    "bus.toml": b"[bus]\nbit_rate = 500\n",
}
OF_BUS = ("--interface", "virtual", "--for", "0.01")
CDL, BUS, DEVICE = "a CDL file", "a bus file", "a description of a device"
COMMANDS = (
    (("rpc", "list", "{}"), CDL, "arm.idl drive.eds system.xml bus.toml"),
    (
        ("rpc", "encode", "sLamp.off", "--request", "{{}}", "--cdl", "{}"),
        CDL,
        "arm.idl",
    ),
    (("rpc", "serve", "--signature", "sLamp", "--cdl", "{}"), CDL, "drive.eds"),
    (("can", "monitor", *OF_BUS, "--bus", "{}"), BUS, "arm.idl system.xml editor.cde"),
    (("can", "timing", "{}"), BUS, "drive.eds arm.idl lamp.cdl"),
    (("can", "monitor", *OF_BUS, "--eds", "1={}"), DEVICE, "arm.idl lamp.cdl"),
)


@pytest.fixture(autouse=True)
def files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for name, content in FILES.items():
        Path(name).write_bytes(content)


@pytest.mark.parametrize(
    ("command", "kind", "name"),
    [(command, kind, name) for command, kind, of in COMMANDS for name in of.split()],
)
def test_a_file_of_another_kind(
    command: tuple[str, ...],
    kind: str,
    name: str,
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert run([word.format(name) for word in command]) == 2
    assert capsys.readouterr().err == f"Error: {name} is not {kind}\n"


def test_two_descriptions_of_one_node(capsys: pytest.CaptureFixture[str]) -> None:
    """The same one twice is no contradiction."""
    Path("other.eds").write_bytes(FILES["drive.eds"])
    monitor = ["can", "monitor", *OF_BUS, "--eds", "1=drive.eds"]
    assert run([*monitor, "--eds", "1=other.eds"]) == 2
    error = "Error: --eds other.eds: node-id 1 is that of drive.eds\n"
    assert capsys.readouterr().err == error
    for other in ("1=drive.eds", "2=other.eds"):
        assert run([*monitor, "--eds", other]) == 0


@pytest.mark.parametrize("name", ["lamp.cdl", "editor.cde", "lamp.txt"])
def test_a_name_of_no_other_kind(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["rpc", "list", name]) == 0
    assert capsys.readouterr().out == "sLamp\n    1  void off(void)\n"


def test_sources_of_the_editor_of_tecs(capsys: pytest.CaptureFixture[str]) -> None:
    Path("rtgen.toml").write_text('[sources]\npaths = ["editor.cde"]\n', "utf-8")
    assert run(["rpc", "list"]) == 0
    assert capsys.readouterr().out.startswith("sLamp\n")


def test_a_form_that_a_device_does_not_have(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert run(["convert", "drive.eds", "--to", "dbc"]) == 2
    error = capsys.readouterr().err
    assert "a description of a device has no form dbc" in error
    assert "--to eds, --to dcf, --to xdd, --to xdc" in error


def test_a_board_of_no_signature(capsys: pytest.CaptureFixture[str]) -> None:
    Path("types.cdl").write_text("typedef int32_t count_t;\n", "utf-8")
    assert run(["conformance", "types.cdl", "--connect", "tcp:127.0.0.1:1"]) == 2
    assert capsys.readouterr().err == "Error: types.cdl has no signature\n"
