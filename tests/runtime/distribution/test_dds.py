"""Tests of DDS only: types, QoS, programs of cyclonedds, killed processes."""

from __future__ import annotations

import json
import os
import random
import re
import signal
import socket
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import Any

import pytest
from distributed_system import Process, arrived, sample
from in_process import Network
from patience import PATIENCE, until
from seeds import cases

pytest.importorskip("cyclonedds", reason="cyclonedds is not installed")

from media import DOMAIN
from runs import CONSOLE, GOAL, ROBOT, SYSTEM, TO_GOAL, WAY, Run, Wheels, leased

from refrobots import iis, rtc
from rtgen import runtime
from rtgen.cli import run as rtgen
from rtgen.compiler.diagnostics import ToolError
from rtgen.runtime import idl, xcdr
from rtgen.runtime.cdr import Aggregated, CdrError
from rtgen.runtime.dds import entities
from rtgen.runtime.dds.medium import DdsMedium, configuration
from rtgen.runtime.dds.numbers import DOUBLE, Numbers, numbered, plain
from rtgen.runtime.dds.types import idl_class
from rtgen.runtime.distribution.data import encoder
from rtgen.runtime.distribution.medium import (
    MediumError,
    PublishTimeoutError,
    Qos,
    Sample,
    Topic,
    representation,
)
from rtgen.runtime.distribution.payloads import received
from rtgen.runtime.distribution.services import RemoteCalls
from rtgen.runtime.distribution.transport import DistributedTransport
from rtgen.runtime.opaque_rpc.interface import OpaqueRpc, OpaqueRpcFailed
from rtgen.tools.kit.console import Console
from rtgen.tools.running.transports import await_others

PEER = Path(__file__).with_name("cyclone_peer.py")
RPC_PEER = Path(__file__).with_name("cyclone_rpc_peer.py")


class Text(Aggregated):
    """A string, whose length is seldom a multiple of four."""

    _descriptor_ = idl.struct("Text", text=idl.STRING)

    text: str = ""


@pytest.fixture
def partition() -> str:
    return f"test-{os.urandom(8).hex()}"


@pytest.fixture
def stack() -> Iterator[ExitStack]:
    with ExitStack() as stack:
        yield stack


def medium(stack: ExitStack, partition: str) -> DdsMedium:
    """Return a further participant, which ends with the test."""
    made = DdsMedium(partition, domain=DOMAIN)
    stack.callback(made.close)
    return made


# Types and samples.


STRUCTS = [
    type_
    for module in (iis, rtc)
    for _, type_ in sorted(vars(module).items())
    if isinstance(type_, type)
    and issubclass(type_, Aggregated)
    and "WString" not in type_.__name__
]


@pytest.mark.parametrize("type_", STRUCTS, ids=lambda type_: type_.__name__)
def test_cyclonedds_reads_what_our_codec_writes(type_: type[Any]) -> None:
    value = type_()
    payload = encoder(type_)(value)
    assert payload == xcdr.serialize(value, representation(type_))
    theirs = idl_class(type_)
    read = theirs.deserialize(payload)
    version = representation(type_).version
    again = read.serialize(use_version_2=version == 2)
    assert xcdr.deserialize(type_, again) == value
    theirs.__idl__.fill_type_data()
    assert theirs.__idl__.idl_transformed_typename == type_._descriptor_.name


class Wide(Aggregated):
    """A type that cyclonedds does not support."""

    _descriptor_ = idl.struct("Wide", text=idl.WSTRING)

    text: str = ""


def test_a_type_that_dds_does_not_have_is_refused(
    stack: ExitStack, partition: str
) -> None:
    with pytest.raises(MediumError, match="wstring cannot be sent over DDS"):
        medium(stack, partition).publisher(Topic("t", Wide), Qos())


def test_samples_are_numbered_without_change_of_meaning() -> None:
    payload = encoder(rtc.TimedLong)(rtc.TimedLong(data=5))
    numbers = Numbers()
    assert numbers.sequence("other", payload, 1) is None
    sent = [1, 2, 5, 16383, 16384, 16385, 40000]
    marked = [numbered(payload, number) for number in sent]
    found = [numbers.sequence("one", m, stamp) for stamp, m in enumerate(marked[:6])]
    assert found == sent[:6]
    assert numbers.sequence("one", marked[5], 5) == DOUBLE
    assert [plain(each) for each in marked] == [payload] * len(marked)
    # Losses of more than a cycle cannot be counted.
    assert numbers.sequence("one", marked[6], 6) == 40000 - 16383
    for each in marked:
        assert xcdr.deserialize(rtc.TimedLong, each).data == 5
        assert idl_class(rtc.TimedLong).deserialize(each).data == 5


def test_what_a_writer_sends_again_is_known_by_its_time() -> None:
    payload = encoder(rtc.TimedLong)(rtc.TimedLong(data=5))
    numbers = Numbers()
    sent = [(number, numbered(payload, number)) for number in (3, 4, 5)]
    assert [numbers.sequence("one", m, at) for at, m in sent] == [3, 4, 5]
    assert {numbers.sequence("one", m, at) for at, m in sent} == {DOUBLE}
    # Also with a clock that was set back: an increasing number is a new sample.
    assert numbers.sequence("one", numbered(payload, 6), 1) == 6
    # More than half a cycle was lost.
    assert numbers.sequence("one", numbered(payload, 16000), 9) == 16000


@pytest.mark.peer
def test_a_program_of_cyclonedds_reads_and_drives_a_component(
    stack: ExitStack, partition: str
) -> None:
    process = stack.enter_context(Process(medium(stack, partition), "a"))
    node = process.node("a")
    node.out.write(sample(0))
    peer = stack.enter_context(
        subprocess.Popen(
            [sys.executable, str(PEER), str(DOMAIN), partition, configuration(None)],
            stdout=subprocess.PIPE,
            text=True,
        )
    )
    stack.callback(peer.kill)
    until(lambda: node.take() or peer.poll() is not None)
    topic = process.transport._published["a"].topics["out"]
    until(lambda: topic.open().matched or peer.poll() is not None)
    for number in range(5):
        node.out.write(sample(number))
    output, _ = peer.communicate(timeout=PATIENCE)
    assert json.loads(output) == [0, 1, 2, 3, 4]
    numbers = node.take()
    assert numbers == sorted(set(numbers))
    # What came while nobody took it has overflowed the buffer.
    assert numbers[-1] - numbers[0] + 1 - len(numbers) <= node.inward.lost
    assert numbers[0] % 1 == 0.5


def test_padding_that_is_not_stated_is_left_out() -> None:
    stated = xcdr.serialize(Text("ab"), representation(Text))
    assert stated[3] == 1
    silent = stated[:3] + b"\0" + stated[4:]
    assert received(Text, silent) == received(Text, stated) == Text("ab")
    for wrong in (silent + bytes(4), silent[:8]):
        with pytest.raises(CdrError):
            received(Text, wrong)


@pytest.fixture
def rpc_peer(stack: ExitStack, partition: str) -> Callable[[str], Any]:
    """Return a function that starts the program of DDS-RPC as `call` or `serve`."""

    def started(role: str) -> subprocess.Popen[str]:
        command = [sys.executable, str(RPC_PEER), str(DOMAIN), partition]
        process = stack.enter_context(
            subprocess.Popen(
                [*command, configuration(None), role],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                text=True,
            )
        )
        stack.callback(process.kill)
        return process

    return started


@pytest.mark.peer
def test_a_program_of_cyclonedds_calls_a_service(
    stack: ExitStack, partition: str, rpc_peer: Callable[[str], Any]
) -> None:
    process = stack.enter_context(Process(medium(stack, partition), "a"))
    process.activate("a")
    output, _ = rpc_peer("call").communicate(timeout=PATIENCE)
    assert json.loads(output) == [[0, 0, "abab"], [0, 0, 7, "nothing was given"], [5]]
    assert process.node("a").servant.calls == ["begin"] * 3


@pytest.mark.peer
def test_a_program_of_cyclonedds_serves_a_client(
    stack: ExitStack, partition: str, rpc_peer: Callable[[str], Any]
) -> None:
    peer = rpc_peer("serve")
    assert peer.stdout.readline() == "ready\n"
    service = RemoteCalls(medium(stack, partition), OpaqueRpc, "a/given/rpc", PATIENCE)

    def found() -> object:
        try:
            return service.invoke("begin", (b"xy", 3))
        except runtime.ObjectNotExist:
            return None

    assert until(found) == b"yx3"
    with pytest.raises(OpaqueRpcFailed) as failure:
        service.invoke("begin", (b"", 9))
    assert (failure.value.code, failure.value.reason) == (9, "empty")
    assert service.invoke("end", ()) is None
    with pytest.raises(runtime.BadOperation):
        service.invoke("reset", ())


# QoS.


def test_big_samples(stack: ExitStack, partition: str) -> None:
    here, there = medium(stack, partition), medium(stack, partition)
    topic = Topic("t", rtc.TimedOctetSeq)
    got: list[Sample] = []
    there.subscribe(topic, Qos(), got.append)
    publisher = here.publisher(topic, Qos())
    until(lambda: publisher.matched)
    value = rtc.TimedOctetSeq(data=os.urandom(10_000_000))
    publisher.publish(encoder(rtc.TimedOctetSeq)(value))
    until(lambda: got)
    assert xcdr.deserialize(rtc.TimedOctetSeq, got[0].octets) == value


def test_a_slow_reader_holds_up_a_writer_that_keeps_all(
    stack: ExitStack, partition: str
) -> None:
    here, there = medium(stack, partition), medium(stack, partition)
    topic = Topic("t", rtc.TimedOctetSeq)
    go_on = threading.Event()
    got: list[Sample] = []

    def on_sample(one: Sample) -> None:
        go_on.wait(PATIENCE)
        got.append(one)

    qos = Qos(depth=None, patience=0.01)
    there.subscribe(topic, qos, on_sample)
    publisher = here.publisher(topic, qos)
    until(lambda: publisher.matched)
    octets = encoder(rtc.TimedOctetSeq)(rtc.TimedOctetSeq(data=bytes(1000)))

    def has_room() -> bool:
        try:
            publisher.publish(octets)
        except PublishTimeoutError:
            return False
        return True

    sent = 0
    while has_room():
        sent += 1
    go_on.set()
    until(lambda: len(got) == sent)
    assert [one.sequence for one in got] == [*range(1, sent + 1)]


def test_partitions_are_systems(stack: ExitStack, partition: str) -> None:
    here, there = medium(stack, partition), medium(stack, partition + "x")
    got: list[Sample] = []
    there.subscribe(Topic("t", rtc.TimedLong), Qos(), got.append)
    mine = medium(stack, partition)
    mine.subscribe(Topic("t", rtc.TimedLong), Qos(), got.append)
    publisher = here.publisher(Topic("t", rtc.TimedLong), Qos())
    until(lambda: publisher.matched)
    publisher.publish(encoder(rtc.TimedLong)(rtc.TimedLong()))
    until(lambda: got)
    assert len(got) == 1


def test_garbage_on_a_topic_is_counted(
    stack: ExitStack, partition: str, caplog: pytest.LogCaptureFixture
) -> None:
    process = stack.enter_context(Process(medium(stack, partition), "a"))
    other = medium(stack, partition)
    # The same topic, with octets that are no sample of the type.
    publisher = other.publisher(Topic("a/in/in", rtc.TimedDouble), Qos())
    until(lambda: publisher.matched)
    with pytest.raises(MediumError):
        publisher.publish(b"\0\1\0\0")
    publisher.publish(encoder(rtc.TimedDouble)(rtc.TimedDouble(data=4.0)))
    arrived(process.node("a"), [4])


@pytest.mark.random
def test_garbage_at_the_ports_of_a_domain_harms_nobody(
    stack: ExitStack, partition: str, caplog: pytest.LogCaptureFixture
) -> None:
    """Octets that are not RTPS's, and messages of strangers with anything in them."""
    a = stack.enter_context(Process(medium(stack, partition), "a"))
    b = stack.enter_context(Process(medium(stack, partition), "b"))
    connector = b.connect("a.out", "b.in")
    a.connect("a.out", "b.in")
    for process in (a, b):
        process.ready()
    out, node = a.node("a").out, b.node("b")
    until(lambda: out.write(sample(-1)) is not None and node.take())
    # DDSI-RTPS 2.5, 9.6.1.1: the ports of participants for discovery and samples.
    ports = [7410 + 250 * DOMAIN + offset for offset in range(20)]
    sender = stack.enter_context(socket.socket(socket.AF_INET, socket.SOCK_DGRAM))
    for number, case in enumerate(cases(20)):
        drawn = random.Random(case)
        for _ in range(50):
            with suppress(ConnectionError):  # nobody listens at that port
                sender.sendto(strange(drawn), ("127.0.0.1", drawn.choice(ports)))
        out.write(sample(number))
        until(lambda number=number: node.take()[-1] == number)
    arrived = [each for each in node.received if each >= 0]
    assert arrived == [*map(float, range(number + 1))]
    assert connector.lost == connector.arrivals.invalid == 0
    assert len(caplog.messages) < 100


def strange(drawn: random.Random) -> bytes:
    """Return octets, or a message of RTPS by a participant that nobody knows."""
    if drawn.random() < 0.2:
        return drawn.randbytes(drawn.choice((0, 1, 20, 1400, 60_000)))
    message = b"RTPS\2\5\1\x10" + drawn.randbytes(12)
    for _ in range(drawn.randrange(5)):
        # DDSI-RTPS 2.5, 9.4.5.1: kind, flags, length.
        kind = drawn.choice((1, 6, 7, 8, 9, 12, 14, 15, 18, 19, 21, 22, 255))
        body = drawn.randbytes(drawn.choice((0, 4, 20, 28, 200)))
        body = body.replace(drawn.randbytes(1), bytes(1))
        size = drawn.choice((len(body), len(body), 0, 65_535))
        message += (
            bytes((kind, drawn.randrange(16))) + size.to_bytes(2, "little") + body
        )
    return message


def test_readers_come_and_go_while_a_publisher_looks(
    stack: ExitStack, partition: str
) -> None:
    """cyclonedds's own list of matched readers fails if a reader joins while it is made."""
    here, there = medium(stack, partition), medium(stack, partition)
    topic = Topic("t", rtc.TimedLong)
    publisher = here.publisher(topic, Qos())
    over = threading.Event()
    failures: list[Exception] = []

    def look() -> None:
        try:
            while not over.is_set():
                assert publisher.matched in (False, True)
        except Exception as error:
            failures.append(error)

    looking = threading.Thread(target=look)
    looking.start()
    for _ in range(40):
        opened = [there.subscribe(topic, Qos(), lambda _: None) for _ in range(10)]
        until(lambda: publisher.matched)
        for each in opened:
            each.close()
    over.set()
    looking.join()
    assert not failures


def test_bare_exceptions_of_cyclonedds_are_reported() -> None:
    with (
        pytest.raises(MediumError, match="a service: Callfunc cqos errored"),
        entities.reported("a service"),
    ):
        raise Exception("Callfunc cqos errored.")
    with pytest.raises(KeyError), entities.reported("a service"):
        raise KeyError("a defect")


def test_a_domain_has_one_configuration(stack: ExitStack, partition: str) -> None:
    medium(stack, partition)
    with pytest.raises(MediumError, match="open with other options"):
        DdsMedium(partition, domain=DOMAIN, interface="127.0.0.1")


@pytest.fixture
def secure(tmp_path: Path) -> Path:
    """A configuration of Cyclone DDS with security, whose plug-ins do not exist."""
    part = '<Library path="nowhere_{0}" initFunction="i" finalizeFunction="f"/>'
    config = tmp_path / "secure.xml"
    config.write_text(
        "<CycloneDDS><Domain><Security>"
        f"<Authentication>{part.format('auth')}<IdentityCertificate>data:,x"
        "</IdentityCertificate><IdentityCA>data:,x</IdentityCA><PrivateKey>data:,x"
        f"</PrivateKey></Authentication><AccessControl>{part.format('ac')}"
        "<Governance>data:,x</Governance><PermissionsCA>data:,x</PermissionsCA>"
        f"<Permissions>data:,x</Permissions></AccessControl><Cryptographic>"
        f"{part.format('crypto')}</Cryptographic></Security></Domain></CycloneDDS>"
    )
    return config


@pytest.mark.nightly
def test_security_that_cannot_be_had_is_refused(secure: Path, partition: str) -> None:
    """The wheel of cyclonedds has no security: nothing is sent in the clear instead."""
    with pytest.raises(MediumError, match="domain 89"):
        DdsMedium(partition, domain=89, config=secure)
    options = ["--clock", "real", "--transport", "dds", "--domain", "89"]
    options += ["--transport-config", str(secure), "--until", "0.1"]
    # The C library logs where the first domain of a process does.
    done = subprocess.run(
        [sys.executable, "-m", "rtgen", "run", str(SYSTEM), *options],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 3
    assert f"--transport-config {secure}: Cyclone DDS does not start" in done.stderr
    assert "Security: unknown element" in done.stderr
    assert not re.search(r"^\d+\.\d+ \[", done.stderr, re.MULTILINE)


# The command.


@pytest.mark.parametrize(
    ("options", "code", "text"),
    [
        (["--transport", "dds"], 2, "--transport dds needs --clock real"),
        (["--domain", "1"], 2, "--domain needs --transport dds"),
        (["--clock", "real", "--transport", "dds", "--nameserver", "x"], 2, "corba"),
        (
            ["--clock", "real", "--transport", "dds", "--partition", "a b"],
            2,
            "'a b' cannot be a name between processes",
        ),
        (
            ["--clock", "real", "--transport", "dds", "--partition", ""],
            2,
            "'' cannot be a name between processes",
        ),
        (
            ["--clock", "real", "--transport", "dds", "--interface", "nowhere0"],
            3,
            "--interface nowhere0: Cyclone DDS does not start with it",
        ),
        (
            ["--clock", "real", "--transport", "dds", "--transport-config", __file__],
            3,
            "CYCLONEDDS_URI is this file",
        ),
    ],
)
def test_options_that_do_not_fit(
    options: list[str], code: int, text: str, capfd: pytest.CaptureFixture[str]
) -> None:
    more = ["--domain", "91"] if "real" in options and code == 3 else []
    assert rtgen(["run", str(SYSTEM), *options, *more, "--until", "0.1"]) == code
    assert text in capfd.readouterr().err


def test_who_is_awaited_is_said(
    partition: str, capfd: pytest.CaptureFixture[str]
) -> None:
    options = ["--clock", "real", "--transport", "dds", "--partition", partition]
    options += ["--domain", str(DOMAIN), "--only", "PathFollower0", "--wait", "1.3"]
    assert rtgen(["run", str(SYSTEM), *options]) == 3
    printed = capfd.readouterr().err
    assert "waiting for other processes: Navigation0, " in printed
    assert "start the process that runs it" in printed


def test_a_process_cannot_keep_a_shorter_lease_than_its_own(
    stack: ExitStack, partition: str, tmp_path: Path
) -> None:
    topic, qos = Topic("x/out", rtc.TimedDouble), Qos(lease=0.5)
    with pytest.raises(MediumError, match=r"x/out: a lease of 0\.5 s .* is 2 s"):
        medium(stack, partition).publisher(topic, qos)
    made = DdsMedium(partition, domain=DOMAIN, lease=0.5)
    stack.callback(made.close)
    made.publisher(topic, qos).close()


@pytest.mark.sampled(0)
def test_a_process_that_stands_still_is_lost_after_the_lease_of_a_connection(
    stack: ExitStack, tmp_path: Path, partition: str
) -> None:
    """The default lease would exceed the duration of the test."""
    file = tmp_path / "cyclonedds.xml"
    file.write_text(configuration(None, lease=3600), encoding="ascii")
    watcher = DdsMedium(partition, domain=88, config=file)
    stack.callback(watcher.close)
    options = ["dds", "--domain", "88", "--partition", partition]
    options += ["--transport-config", str(file)]
    run = Run(tmp_path, options, CONSOLE, system=leased(tmp_path, 0.5))
    stack.callback(run.kill)
    seen: list[bool] = []
    watcher.watch("PositionInput0/", lambda _, present: seen.append(present))
    until(lambda: seen)
    run.process.send_signal(signal.SIGSTOP)
    until(lambda: len(seen) > 1)
    assert seen == [True, False]


def test_a_second_process_for_an_instance_is_to_end(stack: ExitStack) -> None:
    transport = stack.enter_context(DistributedTransport(Network().medium()))

    def refuse(seconds: float) -> None:
        raise runtime.ServedElsewhereError("another process runs a, too")

    transport.await_others = refuse  # type: ignore[method-assign]
    with pytest.raises(ToolError) as failure:
        await_others(transport, 0, Console("text", False, False))
    assert failure.value.hint is not None
    assert failure.value.hint.startswith("end the other process")


@pytest.fixture
def start(tmp_path: Path, partition: str) -> Iterator[Callable[..., Run]]:
    runs: list[Run] = []
    transport = ["dds", "--domain", str(DOMAIN), "--partition", partition]

    def started(only: str, *more: str) -> Run:
        runs.append(Run(tmp_path, transport, only, *more))
        return runs[-1]

    yield started
    for run in runs:
        run.kill()


@pytest.mark.nightly
def test_rh3_in_three_processes_survives_the_loss_of_one(
    start: Callable[..., Run], stack: ExitStack, partition: str
) -> None:
    """The controlling process is killed while the wheels turn: they stop until it is back."""
    wheels = Wheels()
    watch = medium(stack, partition)
    for name, type_, heard in (
        ("RefHardRh30/out/OutWheelAngle", rtc.TimedDoubleSeq, wheels.on_angles),
        ("PathFollower0/out/velocity", iis.TimedVelocity2D, wheels.on_command),
    ):

        def on_sample(one: Sample, heard: Callable[[bytes], None] = heard) -> None:
            heard(one.octets)

        watch.subscribe(Topic(name, type_), Qos(), on_sample)
    robot = start(ROBOT)
    way = start(WAY)
    console = start(CONSOLE, *TO_GOAL)
    for run, instance in (
        (robot, "Odometry0"),
        (way, "PathFollower0"),
        (console, "PositionInput0"),
    ):
        run.wait_for(f"{instance} ACTIVE")
    until(lambda: wheels.turn)
    way.kill()
    robot.wait_for("PathFollower0 is lost")
    console.wait_for("Navigation0 is lost")
    until(lambda: len(wheels.after_bound()) >= 50)
    assert len(set(wheels.after_bound())) == 1
    again = start(WAY)
    again.wait_for("PathFollower0 ACTIVE")
    console.wait_for("Navigation0 is there again")
    console.process.wait(PATIENCE)
    assert console.process.returncode == 0, console.errors
    robot.process.send_signal(signal.SIGTERM)
    output, _ = robot.process.communicate(timeout=PATIENCE)
    [pose] = re.findall(r"final pose +\((\S+), (\S+), (\S+)\)", output)
    assert abs(float(pose[0]) - GOAL[0]) < 0.05
    assert abs(float(pose[1]) - GOAL[1]) < 0.05
