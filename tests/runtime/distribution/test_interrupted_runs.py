"""Ctrl-C and SIGTERM end a run over each transport, with a message and exit code 130."""

from __future__ import annotations

import os
import re
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import media
import pytest
from patience import PATIENCE
from runs import CONSOLE, ROBOT, WAY, Run

pytestmark = pytest.mark.waits


@contextmanager
def options_of(kind: str) -> Iterator[list[str]]:
    """Yield the options of a transport that no other run uses."""
    with media.transports(kind):
        if kind == "dds":
            partition = f"test-{os.urandom(8).hex()}"
            yield [kind, "--domain", str(media.DOMAIN), "--partition", partition]
        elif kind == "zenoh":
            yield [kind, "--listen", "tcp/127.0.0.1:0"]
        else:
            from rtgen.runtime.corba.name_server import NameServer

            with NameServer() as server:
                yield [kind, "--nameserver", server.address]


@pytest.fixture(params=["corba", "dds", "zenoh"])
def transport(request: pytest.FixtureRequest) -> Iterator[list[str]]:
    with options_of(request.param) as options:
        yield options


def interrupted(run: Run, text: str, number: signal.Signals) -> tuple[int, str, str]:
    """Return exit code and output of a run that gets a signal once it has printed a text."""
    try:
        run.wait_for(text)
        run.process.send_signal(number)
        output, _ = run.process.communicate(timeout=PATIENCE)
        return run.process.returncode, output, run.errors
    finally:
        run.kill()


@pytest.mark.sampled(1)
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_run_is_interrupted(
    transport: list[str], number: signal.Signals, tmp_path: Path
) -> None:
    all_of_them = ",".join((ROBOT, WAY, CONSOLE))
    run = Run(tmp_path, transport, all_of_them, "--until", "600")
    code, output, errors = interrupted(run, "PathFollower0 ACTIVE", number)
    assert code == 130, errors
    assert re.search(r"^interrupted at \d+\.\d{3} s of 600 s$", errors, re.M)
    assert "final pose" in output
    assert "Traceback" not in errors


@pytest.mark.sampled(1)
def test_a_run_that_waits_for_others_is_interrupted(
    transport: list[str], tmp_path: Path
) -> None:
    run = Run(tmp_path, transport, WAY, "--until", "600")
    code, output, errors = interrupted(run, "waiting for other", signal.SIGINT)
    assert (code, output) == (130, ""), errors
    assert "Traceback" not in errors
