"""Devices and addresses of joins: the text of the CDL arrives at the serial line unchanged."""

from __future__ import annotations

from pathlib import Path

import pytest

from rtgen.cli import run
from rtgen.runtime.rtc import conf_file

CDL = """signature sLamp {{ int32_t dim( [in] int32_t percent ); }};
celltype tLamp {{ entry sLamp eLamp; }};
[active] celltype tSwitch {{ call sLamp cLamp; }};
cell tLamp Lamp {{ }};
cell tSwitch Switch {{ [through( RTCPlugin, "{}" )] cLamp = Lamp.eLamp; }};
"""


@pytest.fixture
def work(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("RTGEN_CACHE_DIR", str(tmp_path / "cache"))
    return tmp_path


@pytest.mark.sampled(8)
@pytest.mark.parametrize("target", ["embedded", "openrtm"])
@pytest.mark.parametrize(
    "device",
    [
        r"\\.\COM12",
        "COM3",
        "/dev/ttyUSB0",
        "/dev/serial/by-id/usb-A & B",
        "a:b=c",
        r"a\t\n\\b",
        "#1",
        "%PATH%",
        "é",
    ],
)
def test_devices(work: Path, device: str, target: str) -> None:
    written = device.replace("\\", "\\\\")
    Path("board.cdl").write_text(CDL.format(f"device=!{written}!"), encoding="utf-8")
    arguments = ["-q", "-o", "out", "--target", target]
    assert run(["generate", *arguments, "board.cdl"]) == 0
    [file] = Path("out").rglob("OpaqueRpcCommunication0.conf")
    found = conf_file.read(file)
    assert found.active_set == "mode1"
    assert found.sets["mode1"]["port"] == device


@pytest.mark.parametrize("option", ["device", "address"])
@pytest.mark.parametrize("text", ["C:\\", "\x7f", "\ufeff", "\u2028", " "])
def test_texts_without_a_line_of_their_own_are_refused_at_their_place(
    work: Path, option: str, text: str, capfd: pytest.CaptureFixture[str]
) -> None:
    written = text.replace("\\", "\\\\")
    Path("board.cdl").write_text(CDL.format(f"{option}=!{written}!"), encoding="utf-8")
    assert run(["generate", "-o", "out", "board.cdl"]) == 2
    assert "board.cdl:5:" in capfd.readouterr().err
    assert not Path("out").exists()
