"""A failing user component: output, position and end of `rtgen run`."""

from __future__ import annotations

import json
import re
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from user_project import (
    CONTROLLER,
    DOCS,
    PATIENT,
    TEN_WAYS,
    Break,
    apply,
    forget_modules,
    write,
)

from rtgen.cli import run

WARM = ["run", "warm.xml", "--until", "1"]
BY_NAME = {change.name: change for change in TEN_WAYS}
PRINTED = [change for change in TEN_WAYS if change.name != "waiting"]


@pytest.fixture(scope="module")
def generated(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("warmth")
    write(folder)
    return folder


@pytest.fixture
def project(
    generated: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> Iterator[Path]:
    folder = tmp_path / "project"
    shutil.copytree(generated, folder)
    monkeypatch.chdir(folder)
    monkeypatch.setattr(sys, "path", list(sys.path))
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    forget_modules()
    yield folder
    forget_modules()


def test_the_page_runs(project: Path, capfd: pytest.CaptureFixture[str]) -> None:
    assert run(["run", "warm.xml", "--until", "60"]) == 0
    out = capfd.readouterr().out
    assert "Heater0      ACTIVE    600         0     0\n" in out
    page = (DOCS / "systems.md").read_text()
    assert out.split("wall")[0] in page


@pytest.mark.sampled(3)
@pytest.mark.parametrize("change", PRINTED, ids=lambda change: change.name)
def test_ten_ways_to_break_a_component(
    change: Break, project: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    apply(change, project)
    assert run(WARM) == change.code
    out, err = capfd.readouterr()
    assert f"{CONTROLLER}:{change.line}:" in err
    [finding] = [line for line in err.splitlines() if change.page in line]
    assert finding in (DOCS / "debugging.md").read_text()
    assert err.count("Traceback (most recent call last)") <= 1
    assert "rtgen/runtime" not in err
    assert (out == "") is (change.code != 1)


def test_the_findings_of_a_run_are_one_document(
    project: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    apply(BY_NAME["a name"], project)
    assert run([*WARM, "--diagnostics", "json"]) == 1
    [finding] = json.loads(capfd.readouterr().err)
    place = (finding["file"], finding["line"], finding["column"])
    assert place == (CONTROLLER, 18, 30)
    assert finding["code"] == "SYS0021"
    assert finding["message"] == BY_NAME["a name"].page


@pytest.mark.parametrize(
    ("form", "there", "missing"),
    [
        ("none", ["   18 |", "^^^^"], ["Traceback"]),
        (
            "short",
            ["Traceback", f'File "{CONTROLLER}", line 18'],
            ["execution_context", "participant.py"],
        ),
        ("full", ["Traceback", "participant.py", f'File "{CONTROLLER}"'], []),
    ],
)
def test_traceback(
    form: str,
    there: list[str],
    missing: list[str],
    project: Path,
    capfd: pytest.CaptureFixture[str],
) -> None:
    apply(BY_NAME["a name"], project)
    assert run([*WARM, "--traceback", form]) == 1
    err = capfd.readouterr().err
    for text in there:
        assert text in err
    for text in missing:
        assert text not in err


def write_bad_samples(project: Path) -> None:
    """Let the controller write texts, and the heater not read them."""
    file = project / CONTROLLER
    file.write_text(file.read_text().replace("Power(100.0 if", "Power('hot' if"))
    heater = project / "src/heating/heater.py"
    heater.write_text(heater.read_text().replace("= power.watt", "= 0.0"))


@pytest.mark.parametrize(
    ("options", "file"),
    [
        (["--record", "warm.mcap"], "warm.mcap"),
        (["--csv", "Controller0.power", "--csv", "warm.csv"], "warm.csv"),
        (["--csv", "Heater0.power", "--csv", "warm.csv"], "warm.csv"),
    ],
)
def test_samples_that_cannot_be_written_are_reported(
    options: list[str], file: str, project: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    write_bad_samples(project)
    assert run([*WARM, "-q", "--check-values", "never", *options]) == 1
    [line] = capfd.readouterr().err.splitlines()
    assert line.startswith(f"error[SYS0028]: {file}: ")
    port = options[1] if "." in options[1] and options[0] == "--csv" else ""
    reason = "missing: Power.watt: a value of double is needed, not 'hot'"
    assert f"samples of {port or 'Controller0.power'} are {reason}" in line


def test_samples_that_a_log_cannot_hold_are_reported(
    project: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    write_bad_samples(project)
    file = project / CONTROLLER
    file.write_text(file.read_text().replace("'hot'", "object()"))
    options = ["-q", "--check-values", "never", "--log", "warm.jsonl"]
    assert run([*WARM, *options]) == 1
    [line] = capfd.readouterr().err.splitlines()
    assert line.startswith("error[SYS0028]: warm.jsonl: ")
    assert "samples of Controller0.power are missing: Power.watt: " in line


@pytest.mark.parametrize("check", ["always", "first"])
def test_a_value_of_a_wrong_type_stops_its_writer(
    check: str, project: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    write_bad_samples(project)
    assert run([*WARM, "--check-values", check, "--traceback", "none"]) == 1
    err = capfd.readouterr().err
    assert (
        f"{CONTROLLER}:18:13: error[SYS0021]: Controller0.on_execute at 0.000 s: CdrError: "
        "Controller0.power: Power.watt: a value of double is needed, not 'hot'"
    ) in err


def test_a_callback_with_other_parameters_is_shown_where_it_is_defined(
    project: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    change = Break("", "on_execute(self, ec_id: int)", "on_execute(self)", 1, 0, "")
    apply(change, project)
    assert run(WARM) == 1
    err = capfd.readouterr().err
    assert f"{CONTROLLER}:13:" in err
    assert (
        "Controller0.on_execute at 0.000 s: ParametersError: Controller.on_execute() takes 1 "
        "positional argument but 2 were given"
    ) in err
    assert "rtgen/runtime" not in err


def test_lost_samples_are_reported_with_port_reason_and_advice(
    project: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    change = Break("", "= self.temperature.read_newest()", "= None", 0, 0, "")
    apply(change, project)
    assert run(["run", "warm.xml", "--until", "2"]) == 0
    assert capfd.readouterr().out.splitlines()[-1] == (
        "Controller0.temperature: 12 samples of Heater0.temperature lost: the buffer of 8 "
        "was full, newer ones took their place; read while is_new(), or read_newest(), in "
        "each tick; where more come between two ticks, dataport.buffer.length of the connection "
        "holds them"
    )


def test_overruns_are_reported_with_reason_and_advice(
    project: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    slow = "            __import__('time').sleep(0.15)\n            cold ="
    apply(Break("", "            cold =", slow, 0, 0, ""), project)
    assert run(["run", "warm.xml", "--until", "0.6", "--clock", "real"]) == 0
    out = capfd.readouterr().out
    assert " of a period of 100 ms; do less in on_execute, or lower the rate" in out
    assert "Controller0: " in out.partition("elapsed [s]")[2]


@pytest.mark.parametrize(("name", "code"), [(None, 0), ("a name", 1)])
def test_quiet_prints_findings_only(
    name: str | None, code: int, project: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    if name is not None:
        apply(BY_NAME[name], project)
    assert run([*WARM, "-q", "--traceback", "none"]) == code
    out, err = capfd.readouterr()
    assert out == ""
    assert err.count("error[") == code
    assert "ACTIVE" not in err


def _rtgen(*arguments: str, stdin: str = "") -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-c", PATIENT, *arguments],
        input=stdin,
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )


CLOCKS = ["sim", pytest.param("real", marks=pytest.mark.slow)]


@pytest.mark.sampled(1)
@pytest.mark.parametrize("clock", CLOCKS)
def test_pdb_opens_in_the_failing_frame(project: Path, clock: str) -> None:
    apply(BY_NAME["a name"], project)
    done = _rtgen(*WARM, "--pdb", "--clock", clock, stdin="p measured\nq\n")
    assert done.returncode == 1
    assert "-> self.power.write(Powr(100.0" in done.stdout
    assert "Temperature(value=" in done.stdout
    assert f"Controller0: on_execute ({CONTROLLER}:18): NameError" in done.stdout


@pytest.mark.sampled(1)
@pytest.mark.parametrize("clock", CLOCKS)
def test_quit_at_a_breakpoint_ends_the_run(project: Path, clock: str) -> None:
    line = "            cold ="
    change = Break("", line, f"            breakpoint()\n{line}", 1, 17, "")
    apply(change, project)
    done = _rtgen(*WARM, "--clock", clock, stdin="p 6 * 7\nc\nq\n")
    assert done.returncode == 1
    assert "(Pdb) 42" in done.stdout
    # Before Python 3.13, `breakpoint()` stops at the next line.
    at = 17 + (sys.version_info < (3, 13))
    assert f"Controller0: on_execute ({CONTROLLER}:{at}): BdbQuit" in done.stdout
    # In real time it may tick before there is a sample.
    ticks = "       2 " if clock == "sim" else ""
    assert f"Controller0  ERROR{ticks}" in done.stdout


def _interrupted(callback: str, *arguments: str) -> tuple[int, str]:
    """Return the exit code and the output of a run that gets Ctrl-C once that callback blocks.

    On a busy machine other callbacks are reported, too, before they return.
    """
    with subprocess.Popen(
        [sys.executable, "-u", "-c", PATIENT, *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    ) as process:
        assert process.stdout is not None
        lines = []
        for line in process.stdout:
            lines.append(line)
            if f".{callback} has not returned for" in line:
                process.send_signal(signal.SIGINT)
        return process.wait(), "".join(lines)


WAIT = "__import__('threading').Event().wait()"
BEFORE_THE_RUN = ("on_initialize", "on_startup")
FIRST = {
    "on_error": "return 1",
    "on_aborting": "return 1",
    "on_reset": "return 1",
    "on_rate_changed": "self.get_context(0).set_rate(5.0)",
}
"""The first statement of `on_execute`, so that the callback is called."""
ASKS_FOR_RESET = """\
    def on_error(self, ec_id):
        return self.get_context(0).reset_component(self)

"""
AT_THE_END = ("on_deactivated", "on_shutdown", "on_finalize")
CALLBACKS = (
    *BEFORE_THE_RUN,
    *FIRST,
    "on_activated",
    "on_execute",
    "on_state_update",
    *AT_THE_END,
)


def blocking(callback: str) -> Iterator[Break]:
    """Yield the controller with a callback that does not return."""
    begin = '        """Full power below the target, none above."""\n'
    if callback == "on_execute":
        yield Break("", begin, f"{begin}        {WAIT}\n", 1, 0, "")
        return
    method = f"    def {callback}(self, *_):\n        {WAIT}\n\n"
    if callback == "on_reset":
        method += ASKS_FOR_RESET
    if callback in FIRST:
        yield Break("", begin, f"{begin}        {FIRST[callback]}\n", 1, 0, "")
    yield Break("", "    def on_execute", f"{method}    def on_execute", 1, 0, "")


@pytest.mark.sampled(1)
@pytest.mark.waits
@pytest.mark.parametrize("clock", ["sim", "real"])
@pytest.mark.parametrize(
    "callback",
    [
        c if c == "on_execute" else pytest.param(c, marks=pytest.mark.slow)
        for c in CALLBACKS
    ],
)
def test_a_callback_that_blocks_is_named_and_ctrl_c_ends_the_run(
    callback: str, clock: str, project: Path
) -> None:
    for change in blocking(callback):
        apply(change, project)
    # Callbacks called at the end must come soon; all others must come before the end.
    until = "0.5" if callback in AT_THE_END else "60"
    command = ("run", "warm.xml", "--until", until, "--clock", clock)
    code, output = _interrupted(callback, *command)
    assert re.search(rf"Controller0\.{callback} has not returned for \d+ s", output)
    assert f"{CONTROLLER}:" in output
    if callback in BEFORE_THE_RUN:
        assert code == 130
    else:
        assert code == 1
        assert "Controller0" in output.partition("instance ")[2]


def test_the_end_of_a_run_gives_up_what_blocks(project: Path) -> None:
    apply(BY_NAME["waiting"], project)
    done = _rtgen("run", "warm.xml", "--until", "0.3", "--clock", "real")
    assert done.returncode == 1
    assert f"{CONTROLLER}:17:13: error[SYS0021]" in done.stderr
    assert "BlockedError: on_execute has not returned" in done.stderr
    assert "elapsed [s]" in done.stdout
    assert "simulated" not in done.stdout


@pytest.mark.slow
def test_code_that_swallows_interrupts_ends_with_the_process(project: Path) -> None:
    old = "            cold ="
    loop = (
        "            while True:\n                try:\n"
        "                    __import__('time').sleep(10)\n"
        "                except BaseException:\n                    pass\n"
    )
    apply(Break("", old, loop + old, 1, 0, ""), project)
    code, output = _interrupted("on_execute", *WARM)
    assert code == 1
    assert "does not end when interrupted" in output


@pytest.mark.parametrize(
    ("text", "code", "said"),
    [
        ("def f(:\n", 2, "SyntaxError"),
        ("x = 1\n\ty = 2\n", 2, "IndentationError"),
        ("from warmth.heating import Powr\n", 2, "cannot import name 'Powr'"),
        ("import warmth.coolin\n", 2, "hint: is `rtgen generate` done?"),
        ("import math\nmath.py\n", 2, "module 'math' has no attribute 'py'"),
        ("import json\njson.loads('')\n", 2, "JSONDecodeError"),
        ("raise SystemExit\n", 2, "SystemExit"),
        ("import no_such_driver\n", 3, "is no_such_driver installed"),
    ],
)
def test_whose_mistake_keeps_a_module_from_being_imported(
    text: str, code: int, said: str, project: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    (project / CONTROLLER).write_text(text)
    assert run(WARM) == code
    err = capfd.readouterr().err
    assert re.search(rf"^{CONTROLLER}:\d+:\d+: error\[SYS0022\]", err, re.M)
    assert said in err
    assert not re.search(r'File ".*rtgen', err)


@pytest.mark.parametrize(
    "statement",
    [
        # Exceptions within the runtime, and those that have one as their cause.
        "self.power.write(Power('hot'))",
        "self.power.write(3)",
        "self.configuration_sets.set('target', 'hot')",
        "self.in_ports['gone']",
        "from rtgen.runtime import xcdr; xcdr.deserialize(Power, b'')",
        "import rtgen.runtime.canopen.bus.links as l; raise ValueError from l.LinkError('x')",
    ],
)
@pytest.mark.parametrize("form", ["short", "full"])
def test_short_tracebacks_have_no_frames_of_rtgen(
    statement: str, form: str, project: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    file = project / CONTROLLER
    text = file.read_text()
    file.write_text(
        text.replace(
            "            cold =", f"            {statement}\n            cold ="
        )
    )
    assert run([*WARM, "--traceback", form]) == 1
    err = capfd.readouterr().err
    assert f'File "{CONTROLLER}", line 17' in err
    assert bool(re.search(r'File "[^"]*rtgen/', err)) is (form == "full")


def test_definitions_of_ros_2_that_ship_with_rtgen_are_not_changed(
    project: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    file = project / "idl/heating.idl"
    file.write_text(f'#include "geometry_msgs/msg/Twist.idl"\n{file.read_text()}')
    assert run(["generate", "-q"]) == 0
    forget_modules()
    run([*WARM, "-q"])
    assert "PRJ0020" not in capfd.readouterr().err


def test_a_run_says_that_definitions_have_changed(
    project: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    file = project / "idl/heating.idl"
    text = file.read_text()
    manifest = project / "generated/.rtgen.json"
    warning = (
        "warning[PRJ0020]: definitions have changed since the last rtgen generate: "
    )
    for change, names in (
        (lambda: None, ""),
        (lambda: file.write_text(text.replace("double watt", "float watt")), "idl/heating.idl"),
        (lambda: file.write_bytes(text.replace("\n", "\r\n").encode()), ""),
        (lambda: (project / "idl/more.idl").write_text("struct More {};\n"), "idl/more.idl"),
        (lambda: file.rename(project / "heating.txt"), "idl/heating.idl, idl/more.idl"),
        (manifest.unlink, ""),
    ):  # fmt: skip
        change()
        forget_modules()
        run([*WARM, "-q"])
        err = capfd.readouterr().err
        assert [line for line in err.splitlines() if "PRJ0020" in line] == (
            [warning + names] if names else []
        )
