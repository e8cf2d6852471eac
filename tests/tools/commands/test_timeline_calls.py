"""`call` in timelines: typed values, results and exceptions in the lines of a run."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from gripper_project import write

from rtgen.cli import run

JOB = (
    'what={name = "a\\"b", how: ON, way=[{x=1, y=2.5}], grid=[[1, 2], [3, 0x10]]}, '
    "which={real = 2}, letter='c', raw=[1, 255], fast=true"
)


@pytest.fixture(scope="module")
def generated(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("grips")
    write(folder)
    return folder


@pytest.fixture(autouse=True)
def _project(generated: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    monkeypatch.chdir(generated)
    monkeypatch.setattr(sys, "path", list(sys.path))
    yield
    for name in list(sys.modules):
        if name.partition(".")[0] in ("grips", "hand", "arm"):
            del sys.modules[name]


def timeline(*calls: str, raises: str | None = None) -> list[str]:
    """Write a timeline of calls, one each 100 ms from 0.5 s; return the command that runs it."""
    entries = []
    for number, call in enumerate(calls):
        text = json.dumps(call, ensure_ascii=False)
        value = text if raises is None else f'{{ to = {text}, raises = "{raises}" }}'
        entries.append(f"[[at]]\nt = {0.5 + number / 10}\ncall = {value}\n")
    Path("t.toml").write_text("".join(entries))
    return ["run", "s.xml", "--until", "2", "--timeline", "t.toml"]


@pytest.mark.sampled(4)
@pytest.mark.parametrize(
    ("call", "outcome"),
    [
        ("Hand0.hand.open(4)", " -> 9.0"),
        ("Hand0.hand.open(width=4.5)", " -> 9.5"),
        ("Hand0.hand.Gripper.open(4)", " -> 9.0"),
        ("Hand0.hand.turn(ON, 2.5)", ' -> "ON", turns = 3, speed = 5.0'),
        ("Hand0.hand.turn(Grips::Mode::OFF, 1)", ' -> "OFF", turns = 3, speed = 2.0'),
        ("Hand0.hand.turn(speed=1, how='ON')", ' -> "ON", turns = 3, speed = 2.0'),
        ("Hand0.hand.kick(3)", ""),
        ("Hand0.hand._get_count()", " -> 7"),
        (
            f"Hand0.hand.work({JOB})",
            ' -> {"name": "a\\"b 2.0 c 2 True", "how": "ON", "way": [{"x": 1.0, "y": 2.5}], '
            '"grid": [[1, 2], [3, 16]], "limit": null}',
        ),
    ],
)
def test_results(call: str, outcome: str, capfd: pytest.CaptureFixture[str]) -> None:
    assert run(timeline(call)) == 0
    assert f"\n0.500 s: {call}{outcome}\n" in capfd.readouterr().err


@pytest.mark.parametrize(
    ("call", "what"),
    [
        ("Hand0.hand.open(11)", "raises Grips::Jammed: force=11.0, how="),
        ("Hand0.hand.hold()", "raises UnknownException: "),
    ],
)
def test_exceptions(call: str, what: str, capfd: pytest.CaptureFixture[str]) -> None:
    assert run(timeline(call)) == 1
    err = capfd.readouterr().err
    assert f"t.toml:3:1: error[SYS0030]: {call} at 0.500 s {what}" in err
    assert run([*timeline(call), "--fail-on", "never"]) == 0


def test_an_expected_exception(capfd: pytest.CaptureFixture[str]) -> None:
    for name in ("Grips::Jammed", "Jammed"):
        assert run(timeline("Hand0.hand.open(11)", raises=name)) == 0
        assert (
            "0.500 s: Hand0.hand.open(11) raises Grips::Jammed"
            in capfd.readouterr().err
        )
    assert run(timeline("Hand0.hand.open(4)", raises="Jammed")) == 1
    err = capfd.readouterr().err
    assert "hint: the timeline expects that it raises Jammed" in err
    assert "open(4) at 0.500 s -> 9.0" in err


def test_a_component_that_is_not_active(capfd: pytest.CaptureFixture[str]) -> None:
    command = timeline("Hand0.hand.open(1)")
    text = Path("t.toml").read_text()
    Path("t.toml").write_text('[[at]]\nt = 0.4\ndeactivate = "Hand0"\n' + text)
    assert run(command) == 1
    err = capfd.readouterr().err
    assert "raises ObjectNotExist: Hand0.hand:Gripper is not active" in err
    assert "hint: a component serves calls once it is ACTIVE" in err


@pytest.mark.sampled(5)
@pytest.mark.parametrize(
    ("call", "what"),
    [
        ("Hand0.hand.open", "open: width is missing"),
        ("Hand0.hand.open()", "open: width is missing"),
        ("Hand0.hand.open(1, 2)", "2 arguments; parameters: width"),
        ("Hand0.hand.open(widht=1)", "no parameter 'widht': did you mean width?"),
        ("Hand0.hand.open(x)", "width: 'x' is not a number"),
        ("Hand0.hand.turn(ONN, 1)", "how: 'ONN' is not one of OFF, ON"),
        ("Hand0.hand.kick(256)", "256 is out of the range of octet"),
        ("Hand0.hand.kick(1.5)", "strength: 1.5 is not an integer"),
        ("Hand0.hand.opn(1)", "has no operation 'opn': did you mean open?"),
        ("Hand0.hnd.open(1)", "Hand0 provides no 'hnd': did you mean hand?"),
        ("Arm0.hand.open(1)", "Arm0 provides no 'hand': it has none"),
        ("Hand0.open(1)", "is not INSTANCE.PORT.OPERATION(arguments)"),
        ("Hand0.hand.open(1", "',' or ')' is expected at the end"),
        ("Hand0.hand.open(1))", "goes on after its parentheses"),
        ("Hand0.hand.open(" + "[" * 99, "more than 32 levels"),
    ],
)
def test_what_is_refused_before_the_run(
    call: str, what: str, capfd: pytest.CaptureFixture[str]
) -> None:
    assert run(timeline(call)) == 2
    err = capfd.readouterr().err
    assert "t.toml:3:1: error[SYS0007]: " in err
    assert what in err
    assert "ACTIVE" not in err


def test_an_exception_that_cannot_be_raised(capfd: pytest.CaptureFixture[str]) -> None:
    assert run(timeline("Hand0.hand.open(1)", raises="Jamed")) == 2
    assert "open raises no 'Jamed': did you mean Jammed?" in capfd.readouterr().err
    assert run(timeline("Hand0.hand.hold()", raises="UnknownException")) == 0


IN_JOB = (
    (("x=1", "z=1"), "work: what: way: 'z' is not one of x, y"),
    (("x=1, ", ""), "work: what: way: x is missing"),
    (("y=2.5", "y='c'"), "work: what: way: y: 'c' is not a number"),
    (("[3, 0x10]", "[3]"), "work: what: grid: 1 elements are not 2 to 2"),
    (("0x10", "0x1000000000"), "68719476736 is out of the range of long"),
    (
        ("real = 2", "reel = 2"),
        "work: which: {'reel': 2} is not an object with one of real, whole",
    ),
    (("letter='c'", "letter='cc'"), "work: letter: 'cc' is not a character"),
    (("255", "256"), "work: raw: 256 is out of the range of octet"),
    (("fast=true", "fast=1"), "work: fast: 1 is not true or false"),
)
"""Changes of the call with all kinds of values, and what is said of them."""


@pytest.mark.sampled(8)
@pytest.mark.parametrize(
    ("call", "what"),
    [
        ("Hand0.hand.open(4)", ""),
        ("Hand0.hand.Gripper.turn(ON, speed=1)", ""),
        (f"Hand0.hand.work({JOB})", ""),
        ("Hand0.hand._get_count()", ""),
        ("Hand0.hand.opn(4)", "has no operation 'opn'\n"),
        ("Hand0.hnd.open(4)", "Hand0 provides no 'hnd'\n"),
        ("Hand0.hand.open()", "open: width is missing\n"),
        ("Hand0.hand.open(1, 2)", "open: 2 arguments; parameters: width\n"),
        ("Hand0.hand.open(widht=1)", "open: no parameter 'widht'\n"),
        ("Hand0.hand.open('a')", "open: width: 'a' is not a number\n"),
        ("Hand0.hand.turn(ONN, 1)", "turn: how: 'ONN' is not one of OFF, ON\n"),
        ("Hand0.hand.kick(256)", "kick: strength: 256 is out of the range of octet\n"),
        ("Hand0.hand.work(1, 2, 3, 4, 5)", "work: what: 1 is not an object\n"),
        *(
            (f"Hand0.hand.work({JOB.replace(*change)})", f"{what}\n")
            for change, what in IN_JOB
        ),
    ],
)
def test_check_reads_calls_without_a_run(
    call: str, what: str, capfd: pytest.CaptureFixture[str]
) -> None:
    folder = Path("systems")
    folder.mkdir(exist_ok=True)
    (folder / "system.xml").write_text(Path("s.xml").read_text())
    timeline(call)
    (folder / "timeline.toml").write_text(Path("t.toml").read_text())
    settings = Path("rtgen.toml")
    text = settings.read_text()
    settings.write_text(text.replace('["grips.idl"]', '["grips.idl", "systems"]'))
    try:
        code = run(["check", "--only", "timelines"])
    finally:
        settings.write_text(text)
    err = capfd.readouterr().err
    assert code == (2 if what else 0)
    assert ("systems/timeline.toml:3:1: error[SYS0007]: " in err) is bool(what)
    assert what in err


@pytest.mark.parametrize(("change", "what"), IN_JOB)
def test_a_run_says_the_same(
    change: tuple[str, str], what: str, capfd: pytest.CaptureFixture[str]
) -> None:
    assert run(timeline(f"Hand0.hand.work({JOB.replace(*change)})")) == 2
    assert f"{what}\n" in capfd.readouterr().err


def test_an_unknown_instance_is_skipped(capfd: pytest.CaptureFixture[str]) -> None:
    assert run(timeline("Hnd0.hand.open(1)")) == 0
    assert "warning[SYS0027]" in capfd.readouterr().err


def test_order_and_repetition(capfd: pytest.CaptureFixture[str]) -> None:
    """Calls of one instant are made in the order of the file, the same in each run."""
    Path("t.toml").write_text(
        '[[at]]\nt = 0.5\ncall = ["Hand0.hand.open(1)", "Hand0.hand.kick(2)"]\n'
        '[[at]]\nt = 0.5\ncall = "Hand0.hand.open(3)"\nset = []\n'
    )
    command = ["run", "s.xml", "--until", "1", "--timeline", "t.toml"]
    printed = []
    for _ in range(2):
        assert run([*command, "--csv", "Hand0.width", "--csv", "w.csv"]) == 0
        printed.append(capfd.readouterr().err + Path("w.csv").read_text())
    assert printed[0] == printed[1]
    lines = [line for line in printed[0].splitlines() if "0.500 s: Hand0.hand" in line]
    assert [line.split("hand.")[1][:7] for line in lines] == [
        "open(1)",
        "kick(2)",
        "open(3)",
    ]
    assert "\n0.5,3.0\n" in printed[0]
