"""`rtgen ctl`: components are watched and controlled by command, over each engine."""

from __future__ import annotations

import json
import threading
from collections.abc import Callable, Iterator
from pathlib import Path

import media
import pytest
from distributed_system import Process
from json_schemas import valid
from msgspec import structs
from patience import PATIENCE, until

from rtgen import runtime
from rtgen.cli import run as rtgen
from rtgen.cli.ctl import commands

Ctl = Callable[..., tuple[int, str, str]]
pytestmark = [
    pytest.mark.parametrize("network", ["dds", "zenoh"], indirect=True),
    pytest.mark.waits,
]


@pytest.fixture
def node(start: Callable[..., Process]) -> Iterator[Process]:
    """Yield a running process with the component `b`."""
    process = start("b")
    ended = threading.Event()
    thread = threading.Thread(
        target=process.system.run, kwargs={"until": lambda _: ended.is_set()}
    )
    thread.start()
    yield process
    ended.set()
    thread.join()


@pytest.fixture
def ctl(network: media.Engine, capfd: pytest.CaptureFixture[str]) -> Ctl:
    """Run a command; return exit code, standard output and standard error."""
    assert network.address is not None
    [(name, (place, _))] = json.loads(network.address).items()
    if name == "dds":
        partition = f"{place}/{media.SYSTEM}"
        options = ["--domain", str(media.DOMAIN), "--partition", partition]
    else:
        options = ["--connect", place, "--listen", "tcp/127.0.0.1:0"]
        options += ["--partition", media.SYSTEM]

    def run(*arguments: str) -> tuple[int, str, str]:
        capfd.readouterr()
        code = rtgen(["ctl", *arguments, "--transport", name, *options])
        printed = capfd.readouterr()
        return code, printed.out, printed.err

    return run


@pytest.mark.sampled(1)
def test_components_are_listed_and_shown(node: Process, ctl: Ctl) -> None:
    code, text, _ = ctl("list", "--wait", "20")
    assert code == 0
    assert text.splitlines()[1].split()[:2] == ["b", "INACTIVE"]
    [listed] = valid(
        ctl("list", "--json", "--wait", "20")[1], "ctl.schema.json", "list"
    )
    assert (listed["instance"], listed["state"]) == ("b", "INACTIVE")
    code, text, _ = ctl("show", "b", "--wait", "20")
    assert code == 0
    operations = [line for line in text.splitlines() if line.startswith("  ")]
    assert operations[0] == (
        "  OpaqueRpc::Octets begin(in OpaqueRpc::Octets request, in unsigned long first)"
        " raises (OpaqueRpc::Failed)"
    )
    assert operations[2:] == ["  void end()", "  void reset()"]
    assert [line for line in text.splitlines() if line not in operations] == [
        "b: Node, INACTIVE",
        "in in: RTC::TimedDouble",
        "out out: RTC::TimedDouble",
        "provides given.rpc: OpaqueRpc",
        "requires taken.rpc: OpaqueRpc",
        "gain = 1.0",
    ]
    shown = valid(
        ctl("show", "b", "--json", "--wait", "20")[1], "ctl.schema.json", "show"
    )
    assert shown["out_ports"] == {"out": "RTC::TimedDouble"}
    assert shown["sets"] == {"default": {"gain": "1.0"}}


def test_values_have_the_units_of_the_definition(node: Process, ctl: Ctl) -> None:
    b = node.node("b")
    [gain] = b.configuration_sets.parameters
    b.configuration_sets.bind(b.config, (structs.replace(gain, unit="m/s"),))
    assert ctl("get", "b.gain", "--wait", "20")[:2] == (0, "b.gain = 1.0 [m/s]\n")
    assert ctl("show", "b", "--wait", "20")[1].endswith("\ngain = 1.0 [m/s]\n")
    text = ctl("show", "b", "--json", "--wait", "20")[1]
    shown = valid(text, "ctl.schema.json", "show")
    assert (shown["sets"], shown["units"]) == (
        {"default": {"gain": "1.0"}},
        {"gain": "m/s"},
    )


SYSTEM = """<rts:RtsProfile rts:id="RTSystem:lab:conformance:1" rts:version="0.2" rts:abstract="a"
  rts:creationDate="1970-01-01T00:00:00" rts:updateDate="1970-01-01T00:00:00"
  xmlns:rts="http://www.openrtp.org/namespaces/rts">{}</rts:RtsProfile>"""
COMPONENT = """<rts:Components rts:id="RTC:lab:c:Node:1" rts:instanceName="{}" rts:pathUri="x"
  rts:compositeType="None" rts:isRequired="true"/>"""


def test_the_condition_of_the_system_is_stated(
    node: Process, ctl: Ctl, tmp_path: Path
) -> None:
    file = tmp_path / "system.xml"
    wanted = ("--system", str(file), "--wait", "20")

    def condition(*instances: str) -> str:
        file.write_text(SYSTEM.format("".join(map(COMPONENT.format, instances))))
        [line] = [
            line
            for line in ctl("list", *wanted)[2].splitlines()
            if line.startswith("condition: ")
        ]
        return line.removeprefix("condition: ")

    assert condition("b") == "complete"
    assert condition("a", "b", "c") == "degraded, without a, c"
    node.node("b").fails = True
    assert ctl("activate", "b", "--wait", "20")[0] in (0, 1)
    until(lambda: node.system.state("b") is runtime.LifeCycleState.ERROR_STATE)
    assert condition("b") == "degraded, b in ERROR"
    assert condition("b", "c") == "degraded, without c, b in ERROR"
    assert "condition" not in ctl("list", "--wait", "20")[2]


def test_components_are_steered(node: Process, ctl: Ctl) -> None:
    state = node.system.state
    assert ctl("activate", "b", "--wait", "20") == (0, "", "b ACTIVE\n")
    assert state("b") is runtime.LifeCycleState.ACTIVE_STATE
    code, _, text = ctl("activate", "b", "--wait", "20")
    assert code == 1
    assert "b refuses: PRECONDITION_NOT_MET; it is ACTIVE" in text
    node.node("b").fails = True
    until(lambda: state("b") is runtime.LifeCycleState.ERROR_STATE)
    assert "ERROR (it is to fail)" in ctl("list", "--wait", "20")[1]
    node.node("b").fails = False
    assert ctl("reset", "b", "--wait", "20")[0] == 0
    assert ctl("activate", "b", "--wait", "20")[0] == 0
    assert ctl("deactivate", "b", "--wait", "20")[0] == 0
    assert state("b") is runtime.LifeCycleState.INACTIVE_STATE


@pytest.mark.sampled(1)
def test_parameters_are_read_and_set(node: Process, ctl: Ctl) -> None:
    assert ctl("get", "b", "--wait", "20")[:2] == (0, "b.gain = 1.0\n")
    assert ctl("set", "b.gain=2.5", "--wait", "20")[0] == 0
    until(lambda: node.node("b").config.gain == 2.5)
    text = ctl("get", "b.gain", "--json", "--wait", "20")[1]
    assert valid(text, "ctl.schema.json", "get") == {"b": {"gain": "2.5"}}
    code, _, text = ctl("set", "b.gain=high", "--wait", "20")
    assert code == 1
    assert "gain" in text
    assert ctl("get", "b.speed", "--wait", "20")[0] == 1
    assert ctl("set", "b.gain=4", "--in", "fast", "--wait", "20")[0] == 0
    assert ctl("use", "b", "fast", "--wait", "20")[0] == 0
    until(lambda: node.node("b").config.gain == 4.0)
    code, _, text = ctl("use", "b", "slow", "--wait", "20")
    assert code == 1
    assert text == "Error: b has no configuration set 'slow'; known: default, fast\n"
    code, _, text = ctl("set", "b.speed=1", "--wait", "20")
    assert code == 1
    assert text == "Error: b has no configuration parameter 'speed'; known: gain\n"


def test_changes_are_watched(
    node: Process, ctl: Ctl, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert ctl("watch", "--for", "0.1")[0] == 0
    write = commands.write_out

    def activate_then_end(text: str) -> None:
        write(text)
        if "INACTIVE" not in text:
            raise KeyboardInterrupt
        node.system.activate("b")

    monkeypatch.setattr(commands, "write_out", activate_then_end)
    code, text, _ = ctl("watch", "--json")
    assert code == 0
    events = [valid(line, "ctl.schema.json", "event") for line in text.splitlines()]
    assert [event["state"] for event in events] == ["INACTIVE", "ACTIVE"]


def test_what_is_missing_is_named(node: Process, ctl: Ctl) -> None:
    code, _, text = ctl("show", "nobody", "--wait", "0")
    assert code == 3
    assert "no process has nobody" in text
    assert ctl("set", "gain=1")[0] == 2
    assert ctl("list", "--endpoint", "x")[0] == 2


def activate(node: Process) -> None:
    """Activate the component `b`, so that it serves calls."""
    node.system.activate("b")
    until(lambda: node.system.state("b") is runtime.ACTIVE_STATE)


@pytest.mark.sampled(1)
def test_call(node: Process, ctl: Ctl) -> None:
    activate(node)
    assert ctl("call", "b.given.begin([1, 2], 2)") == (0, "[1, 2, 1, 2]\n", "")
    assert ctl("call", "b.given.rpc.begin", "[1, 2]", "3")[1] == "[1, 2, 1, 2, 1, 2]\n"
    assert ctl("call", "b.given.begin(first=1, request=[0x10])")[1] == "[16]\n"
    assert ctl("call", "b.given.end") == (0, "", "")
    assert node.nodes["b"].servant.calls == ["begin"] * 3 + ["end"]
    code, out, _ = ctl("call", "b.given.begin([1], 1)", "--json")
    assert code == 0
    assert valid(out, "ctl.schema.json", "call") == {"result": [1], "out": {}}


def test_call_raises(node: Process, ctl: Ctl) -> None:
    activate(node)
    code, out, err = ctl("call", "b.given.begin([], 7)")
    assert (code, out) == (1, "")
    assert "b.given.begin([], 7) raises" in err
    assert "raises OpaqueRpc::Failed: code=7, reason='nothing was given'" in err
    code, out, _ = ctl("call", "b.given.begin", "[]", "7", "--json")
    raised = valid(out, "ctl.schema.json", "call")
    assert code == 1
    assert raised["exception"]["members"]["code"] == 7
    assert ctl("call", "b.given.begin([100, 101, 102, 101, 99, 116], 1)")[0] == 1
    node.system.deactivate("b")
    until(lambda: node.system.state("b") is runtime.INACTIVE_STATE)
    code, _, err = ctl("call", "b.given.end()")
    assert code == 1
    assert "raises ObjectNotExist: b.given:rpc is not active" in err


@pytest.mark.parametrize(
    ("arguments", "code", "what"),
    [
        (["b.given.begin(300, 1)"], 2, "300 is not a list"),
        (["b.given.begin([1])"], 2, "first is missing"),
        (["b.given.begin([256], 1)"], 2, "256"),
        (["b.given.begin", "[1]", "-7"], 2, "-7"),
        (["b.given.bgin([1], 1)"], 2, "did you mean begin?"),
        (["b.gven.begin([1], 1)"], 2, "did you mean given?"),
        (["b.begin"], 2, "is not INSTANCE.PORT.OPERATION"),
        (["b.given.begin", "[1"], 2, "expected at the end"),
        (["c.given.end", "--wait", "0.1"], 3, "no process has c; known: b"),
    ],
)
def test_call_refused(
    node: Process, ctl: Ctl, arguments: list[str], code: int, what: str
) -> None:
    printed = ctl("call", *arguments)
    assert printed[0] == code
    assert what in printed[2]
    assert node.nodes["b"].servant.calls == []


def test_hostile_calls_are_refused(
    node: Process, start: Callable[..., Process]
) -> None:
    activate(node)
    transport = start().transport
    transport.await_instance("b", PATIENCE)
    asker = transport.peers.asker("b")
    deep: object = 1
    for _ in range(900):
        deep = [deep]
    for arguments in ([("", deep)], [("", 1)] * 10_000, [("x" * 100_000, 1)]):
        assert asker.call("given", "begin", arguments).refused
    for port, operation in (
        ("", ""),
        ("given", "__init__"),
        ("given", "\0"),
        ("x" * 9999, "end"),
    ):
        assert asker.call(port, operation, []).refused
    assert asker.state().state == "ACTIVE_STATE"
    assert node.nodes["b"].servant.calls == []


def test_a_call_that_waits_keeps_no_other_request_waiting(
    node: Process, ctl: Ctl
) -> None:
    activate(node)
    servant = node.nodes["b"].servant
    code, _, err = ctl("call", "b.given.more(3)", "--call-timeout", "0.2")
    assert code == 3
    assert servant.held.is_set()
    assert "b: " in err
    assert ctl("deactivate", "b")[0] == 0
    servant.wait.set()
