"""The command `rtgen ui` without serving."""

from __future__ import annotations

import re
import signal
import socket
import subprocess
import sys
from pathlib import Path

import pytest
from patience import PATIENCE
from ui_bench import GOAL

from rtgen.cli import run
from rtgen.ui import launch


def test_what_cannot_be_opened_is_reported(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    assert run(["ui"]) == 2
    assert run(["ui", str(tmp_path / "none.xml"), "--no-open"]) in (2, 3)
    broken = tmp_path / "broken.xml"
    broken.write_text("<rts:RtsProfile")
    assert run(["ui", str(broken), "--no-open"]) == 2
    assert run(["ui", str(GOAL), "--no-open", "--bus", str(tmp_path / "no.toml")]) != 0
    assert run(["ui", "--no-open", "--nameserver", "127.0.0.1:99999"]) == 2
    corba = ["--transport", "corba", "--no-open"]
    assert run(["ui", str(GOAL), *corba]) == 2
    assert run(["ui", str(GOAL), *corba, "--nameserver", "127.0.0.1"]) == 2
    assert run(["ui", "run.mcap", "--no-open", "--nameserver", "127.0.0.1"]) == 2
    err = capfd.readouterr().err
    assert "Missing argument 'SYSTEM...', or option '--nameserver'." in err
    assert "'127.0.0.1:99999' is not HOST or HOST:PORT." in err
    assert "Traceback" not in err
    assert "internal error" not in err


@pytest.mark.parametrize(
    ("options", "named"),
    [
        (["--clock", "real"], "--clock"),
        (["--check-values", "never"], "--check-values"),
        (["--transport", "corba"], "--transport"),
        (["--pause"], "--play/--pause"),
        (["--record", "a.mcap"], "--record"),
        (["--nameserver", "127.0.0.1", "--clock", "sim"], "--clock, --nameserver"),
    ],
)
def test_a_recording_needs_no_options_of_a_run(
    options: list[str], named: str, capfd: pytest.CaptureFixture[str]
) -> None:
    assert run(["ui", "run.mcap", "--no-open", *options]) == 2
    text = f"a recording is shown without {named}: no system runs"
    assert text in capfd.readouterr().err


def test_a_port_that_is_taken_is_reported(capfd: pytest.CaptureFixture[str]) -> None:
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        port = other.getsockname()[1]
        assert run(["ui", str(GOAL), "--no-open", "--port", str(port)]) == 3
    assert "cannot listen" in capfd.readouterr().err


def test_what_is_not_installed_is_named(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(launch, "find_spec", lambda name: None)
    assert run(["ui", str(GOAL), "--no-open"]) == 3
    assert "pip install ./runtime '.[ui]' in a clone of rtgen" in capfd.readouterr().err


@pytest.mark.parametrize("built", [False, True])
def test_an_installation_without_the_page_is_reported(
    built: bool,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    if built:
        (tmp_path / "index.html").write_text("<title>rtgen</title>")
    monkeypatch.setattr("rtgen.ui.server.PAGE", tmp_path)
    # A port that is taken ends the command.
    with socket.create_server(("127.0.0.1", 0)) as other:
        port = str(other.getsockname()[1])
        assert run(["ui", str(GOAL), "--no-open", "--port", port]) == 3
    assert ("warning[ENV0003]" in capfd.readouterr().err) is not built


def test_naming_services_need_omniorb(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    def found(name: str) -> object:
        return None if name == "omniORB" else name

    monkeypatch.setattr(launch, "find_spec", found)
    assert run(["ui", "--no-open", "--nameserver", "127.0.0.1"]) == 3
    assert (
        "pip install ./runtime '.[corba]' in a clone of rtgen" in capfd.readouterr().err
    )


@pytest.mark.parametrize(
    ("options", "text"),
    [
        (["--transport", "zenoh", "--nameserver", "here"], "without --nameserver"),
        (["--transport", "zenoh", "--domain", "3"], "--domain needs --transport dds"),
        (["--partition", "rh3"], "--partition needs --transport dds or zenoh"),
    ],
)
def test_options_of_another_transport_are_refused(
    options: list[str], text: str, capfd: pytest.CaptureFixture[str]
) -> None:
    assert run(["ui", str(GOAL), "--no-open", *options]) == 2
    assert text in capfd.readouterr().err


def test_it_listens_on_loopback_alone() -> None:
    command = [sys.executable, "-m", "rtgen", "ui", str(GOAL), "--no-open", "--pause"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        try:
            address = process.stdout.readline()
            found = re.fullmatch(
                r"http://127\.0\.0\.1:(\d+)/\?token=\S{30,}\n", address
            )
            assert found, address
            port = int(found[1])
            socket.create_connection(("127.0.0.1", port), PATIENCE).close()
            # A socket for all addresses of the machine takes these, too.
            for other in ("127.0.0.2", "::1"):
                with pytest.raises(OSError, match=r"refused|unreachable|assign"):
                    socket.create_connection((other, port), PATIENCE)
        finally:
            process.send_signal(signal.SIGINT)
        process.wait(PATIENCE)
