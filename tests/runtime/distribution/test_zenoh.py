"""Tests of Zenoh only: programs of eclipse-zenoh, routers, configuration files, the command."""

from __future__ import annotations

import json
import random
import re
import shutil
import signal
import socket
import struct
import subprocess
import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing, nullcontext, suppress
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import media
import pytest
from distributed_system import Process, sample
from free_ports import free_port
from patience import PATIENCE, until
from seeds import cases

pytest.importorskip("zenoh", reason="eclipse-zenoh is not installed")

import zenoh
from runs import CONSOLE, GOAL, ROBOT, SYSTEM, TO_GOAL, WAY, Run, Wheels, leased

from refrobots._idl.basic_data_type import TimedDouble, TimedDoubleSeq
from rtgen.cli import run as rtgen
from rtgen.runtime import idl
from rtgen.runtime.distribution.medium import (
    MediumError,
    Publisher,
    PublishTimeoutError,
    Qos,
    Sample,
    Topic,
)
from rtgen.runtime.distribution.peers import Presence
from rtgen.runtime.zenoh import flow, session
from rtgen.runtime.zenoh.medium import ZenohMedium
from rtgen.runtime.zenoh.services import ZenohService
from rtgen.runtime.zenoh.session import Endpoints, open_session
from rtgen.runtime.zenoh.topics import is_small

pytestmark = pytest.mark.waits

TIMED_DOUBLE = struct.Struct("<4xIId")
"""XCDR1 of BasicDataType.idl's TimedDouble, after the header: time in s and ns, the number."""
HEADER = b"\0\1\0\0"


@pytest.fixture
def locator() -> str:
    return f"tcp/127.0.0.1:{free_port()}"


@pytest.fixture
def stack() -> Iterator[ExitStack]:
    with ExitStack() as stack:
        yield stack


def plain_session(connect: str) -> zenoh.Session:
    """Return a session as opened by a program without rtgen."""
    config = zenoh.Config()
    config.insert_json5("connect/endpoints", json.dumps([connect]))
    config.insert_json5("listen/endpoints", "[]")
    config.insert_json5("scouting/multicast/enabled", "false")
    return zenoh.open(config)


def test_a_program_of_eclipse_zenoh_reads_and_drives_a_component(
    stack: ExitStack, locator: str
) -> None:
    medium = ZenohMedium("plain", Endpoints(listen=(locator,)))
    node = stack.enter_context(Process(medium, "a")).node("a")
    program = stack.enter_context(plain_session(locator))
    read: list[bytes] = []
    subscriber = program.declare_subscriber(
        "plain/topic/a/out/out/RTC::TimedDouble",
        lambda each: read.append(each.payload.to_bytes()),
    )
    writer = program.declare_publisher("plain/topic/a/in/in/RTC::TimedDouble")
    node.out.write(sample(-1))
    until(lambda: node.out.write(sample(-1)) is not None and read)
    for number in range(500):
        node.out.write(sample(number))
    until(lambda: TIMED_DOUBLE.unpack(read[-1])[2] == 499)
    values = [TIMED_DOUBLE.unpack(octets) for octets in read]
    assert {octets[:4] for octets in read} == {HEADER}
    assert [v for v in values if v[2] >= 0] == [(1, 2, n) for n in range(500)]

    def driven() -> bool:
        writer.put(HEADER + TIMED_DOUBLE.pack(3, 4, 7.5)[4:])
        return node.inward.is_new()

    until(driven)
    value = node.inward.read()
    assert (value.tm.sec, value.tm.nsec, value.data) == (3, 4, 7.5)
    subscriber.undeclare()


@pytest.mark.nightly
def test_a_program_of_eclipse_zenoh_counts_what_it_misses(
    stack: ExitStack, locator: str
) -> None:
    """Zenoh's own features count: source information, and a subscriber's miss listener."""
    medium = ZenohMedium("plain", Endpoints(listen=(locator,)))
    stack.callback(medium.close)
    program = stack.enter_context(plain_session(locator))
    publisher = medium.publisher(Topic("a/out/out", TimedDouble), Qos())
    numbers: list[int] = []
    misses: list[int] = []

    def on_sample(each: zenoh.Sample) -> None:
        assert each.encoding == zenoh.Encoding.APPLICATION_CDR
        numbers.append(each.source_info.source_sn)

    subscriber = zenoh.ext.declare_advanced_subscriber(
        program, "plain/topic/a/out/out/RTC::TimedDouble", on_sample
    )
    subscriber.sample_miss_listener(lambda miss: misses.append(miss.nb))
    until(lambda: publisher.matched)
    sent = 0

    def send(octets: bytes = b"") -> None:
        nonlocal sent
        publisher.publish(octets)
        sent += 1

    def flood() -> None:
        for _ in range(1000):
            send(bytes(50_000))

    until(lambda: send() or numbers)
    until(lambda: flood() or misses)  # Zenoh drops samples when its queues are full
    flooded = sent
    until(lambda: send() or numbers[-1] >= flooded)
    subscriber.undeclare()
    assert sum(misses) == numbers[-1] - numbers[0] + 1 - len(numbers)


def test_the_window_opens_for_any_identity_and_beyond_the_highest_number(
    stack: ExitStack, locator: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Zenoh leaves out trailing zeros of identities."""
    monkeypatch.setattr(flow, "SEQUENCES", 2 * flow.WINDOW)
    session = stack.enter_context(open_session(Endpoints(listen=(locator,))))
    source = b"\7\1", 5
    acknowledging = flow.Acknowledging(session, "s/flow/t/1")
    stack.callback(acknowledging.close)
    window = flow.Window(session, "s/flow/t/*", source, PATIENCE)
    stack.callback(window.close)
    for number in range(5 * flow.WINDOW):
        window.wait("t")
        acknowledging.handled(source, number % flow.SEQUENCES)
    other = flow.Window(session, "s/flow/t/*", (b"\7", 5), 0.05)
    stack.callback(other.close)

    def flood() -> bool:
        for number in range(2 * flow.WINDOW):
            other.wait("t")
            acknowledging.handled(source, number)
        return False  # The subscription was still unknown.

    with pytest.raises(PublishTimeoutError, match="t: a subscription is 64 samples"):
        until(flood)


@pytest.mark.parametrize(
    "octets",
    [b"", b"\0", b"\0\1\0\0", b"\xff" * 64, HEADER + bytes(15), bytes(1 << 20)],
    ids=["nothing", "one", "header", "ones", "cut off", "a megabyte"],
)
def test_garbage_is_counted_and_harms_nobody(
    stack: ExitStack, locator: str, octets: bytes
) -> None:
    first = ZenohMedium("plain", Endpoints(listen=(locator,)))
    a = stack.enter_context(Process(first, "a"))
    second = ZenohMedium("plain", Endpoints(connect=(locator,), listen=(_any(),)))
    b = stack.enter_context(Process(second, "b"))
    connector = b.connect("a.out", "b.in")
    a.connect("a.out", "b.in")
    for process in (a, b):
        process.ready()
    program = stack.enter_context(plain_session(locator))
    keys = (
        "plain/topic/a/out/out/RTC::TimedDouble",
        "plain/topic/b/in/in/RTC::TimedDouble",
        "plain/presence/strange",
        "plain/flow/a/out/out/RTC::TimedDouble/x",
    )

    def send_all() -> int:
        for key in keys:
            program.put(key, octets)
            program.put(key, octets, attachment=octets[:24])
        return connector.arrivals.invalid

    until(send_all)
    for key in ("plain/service/b/control", "plain/service/b/given/rpc"):
        for reply in program.get(key, payload=octets, timeout=0.3):
            assert reply.ok is None or reply.ok.payload.to_bytes()
    token = program.liveliness().declare_token("plain/presence/strange")
    for number in range(5):
        a.node("a").out.write(sample(number))
    until(lambda: b.node("b").take()[-1:] == [4.0])
    assert b.node("b").received == [0.0, 1.0, 2.0, 3.0, 4.0]
    assert connector.lost == connector.arrivals.invalid
    assert not [name for name in b.transport.peers.instances if name not in "ab"]
    token.undeclare()


def _any() -> str:
    return "tcp/127.0.0.1:0"


@pytest.mark.parametrize(
    ("described", "small"),
    [
        (TimedDouble, True),
        (TimedDoubleSeq, False),
        (SimpleNamespace(_descriptor_=idl.array(idl.DOUBLE, 8, 16)), True),
        (SimpleNamespace(_descriptor_=idl.array(idl.OCTET, 129)), False),
        (SimpleNamespace(_descriptor_=idl.array(TimedDouble._descriptor_, 43)), False),
        (SimpleNamespace(_descriptor_=idl.ANY), False),
        (SimpleNamespace(_descriptor_=idl.STRING), False),
    ],
)
def test_types_of_few_numbers_are_small(described: Any, small: bool) -> None:
    assert is_small(described) is small


def test_large_samples_have_a_thread_of_their_own(locator: str) -> None:
    """Links are read on meanwhile."""
    threads: dict[bool, int] = {}
    with closing(ZenohMedium("plain", Endpoints(listen=(locator,)))) as medium:
        for type_ in (TimedDouble, TimedDoubleSeq):
            topic = Topic(type_.__name__, type_)
            is_seq = type_ is TimedDoubleSeq

            def on_sample(sample: Sample, is_seq: bool = is_seq) -> None:
                threads[is_seq] = threading.get_ident()

            medium.subscribe(topic, Qos(), on_sample)
            medium.publisher(topic, Qos()).publish(HEADER)
        until(lambda: len(threads) == 2)
    assert threads[False] == threading.get_ident()
    assert threads[True] != threading.get_ident()


def test_samples_of_several_links_come_one_by_one_without_a_thread_for_them(
    stack: ExitStack, locator: str
) -> None:
    here = stack.enter_context(
        closing(ZenohMedium("plain", Endpoints(listen=(locator,))))
    )
    others = [
        stack.enter_context(
            closing(ZenohMedium("plain", Endpoints(connect=(locator,))))
        )
        for _ in range(3)
    ]
    topic, number = Topic("t", TimedDouble), 50
    taken: dict[object, list[int | None]] = {}
    at_once: list[int] = []
    together = threading.Semaphore(1)

    def on_sample(sample: Sample) -> None:
        if not together.acquire(blocking=False):
            at_once.append(1)
            return
        taken.setdefault(sample.source, []).append(sample.sequence)
        together.release()

    here.subscribe(topic, Qos(depth=number), on_sample)
    mine = here.publisher(topic, Qos())
    mine.publish(HEADER)
    assert [*taken.values()] == [[0]]  # by the sender itself
    publishers = [other.publisher(topic, Qos(depth=number)) for other in others]
    until(lambda: all(publisher.matched for publisher in publishers))

    def send(publisher: Publisher) -> None:
        for _ in range(number):
            publisher.publish(HEADER)

    senders = [threading.Thread(target=send, args=(p,)) for p in publishers]
    for sender in senders:
        sender.start()
    for sender in senders:
        sender.join()
    until(lambda: sum(map(len, taken.values())) == 1 + 3 * number or bool(at_once))
    assert not at_once
    assert sorted(taken.values(), key=len)[1:] == [list(range(number))] * 3


def test_a_router_that_is_started_again_is_found(
    stack: ExitStack, locator: str
) -> None:
    with media.router(locator):
        a, b = (
            stack.enter_context(
                Process(ZenohMedium("s", Endpoints(connect=(locator,))), name)
            )
            for name in ("a", "b")
        )
        connector = b.connect("a.out", "b.in")
        a.connect("a.out", "b.in")
        for process in (a, b):
            process.ready()
    reports: list[tuple[str, Presence]] = []
    a.transport.peers.listeners.append(
        lambda instance, presence: reports.append((instance, presence))
    )
    until(lambda: a.transport.peers.is_lost("b") and b.transport.peers.is_lost("a"))
    with media.router(locator):
        until(lambda: a.transport.peers.is_elsewhere("b"))
        until(lambda: "a" in a.transport.peers.instances)
        node, other = a.node("a"), b.node("b")
        numbers = iter(range(1, 100_000))
        until(
            lambda: (node.out.write(sample(next(numbers))) and other.take())
            or other.take()
        )
        assert other.received == sorted(set(other.received))
        assert connector.arrivals.doubles == 0
        until(lambda: ("b", Presence.BACK) in reports)
        assert {instance for instance, _ in reports} == {"b"}
        b.close()
        a.close()


def test_routers_of_robots_join_at_a_site(stack: ExitStack, locator: str) -> None:
    """The site's router sees a robot by its partition; the robot goes on without the site."""
    site_router = stack.enter_context(ExitStack())
    site_router.enter_context(media.router(locator))
    robots = {}
    places = [f"tcp/127.0.0.1:{free_port()}" for _ in range(2)]
    for name, place in zip(("site/robot1", "site/robot2"), places, strict=True):
        stack.enter_context(media.router(place, locator))
        medium = ZenohMedium(name, Endpoints(connect=(place,)))
        robots[name] = stack.enter_context(Process(medium, "a"))
    medium = ZenohMedium("site/robot1", Endpoints(connect=(locator,)))
    site = stack.enter_context(Process(medium, "b"))
    site.connect("a.out", "b.in")

    def arrives() -> list[float]:
        for name, robot in robots.items():
            robot.node("a").out.write(sample(float(name[-1])))
        return site.node("b").take()

    until(arrives)
    assert set(site.node("b").take()) == {1.0}
    until(lambda: site.transport.peers.is_elsewhere("a"))
    description = site.transport.peers.description("a")
    assert description is not None
    assert list(description.out_ports) == ["out"]
    site_router.close()
    medium = ZenohMedium("site/robot1", Endpoints(connect=(places[0],)))
    c = stack.enter_context(Process(medium, "c"))
    c.connect("a.out", "c.in")

    def goes_on() -> list[float]:
        robots["site/robot1"].node("a").out.write(sample(3.0))
        return c.node("c").take()

    until(goes_on)
    until(lambda: site.transport.peers.is_lost("a"))


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        ("{ mode: 'nothing' }", "nothing"),
        ("{ mode: ", "zenoh.json5: .*expected"),
        ("{ connect: { endpoints: ['here'] } }", "Endpoints must be of the form"),
        ("{ id: 'abc' }", "zenoh.json5 has an `id`: .*leave it out"),
    ],
)
def test_a_wrong_configuration_file_is_reported(
    tmp_path: Path, text: str, wanted: str
) -> None:
    file = tmp_path / "zenoh.json5"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(MediumError, match=wanted) as caught:
        open_session(Endpoints(file))
    assert ".rs:" not in str(caught.value)


def test_a_session_that_does_not_open_is_reported(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    """As if another program held the port where sessions meet."""
    monkeypatch.setattr(session, "_SLOW", 0.01)
    opened = object()

    def slow(_: object) -> object:
        until(lambda: caplog.messages)
        return opened

    monkeypatch.setattr(session.zenoh, "open", slow)
    assert open_session(Endpoints()) is opened
    assert caplog.messages == [
        "Zenoh waits: nobody answers as Zenoh at tcp/127.0.0.1:7447"
    ]


def test_locators_replace_those_of_the_file(tmp_path: Path, locator: str) -> None:
    file = tmp_path / "zenoh.json5"
    file.write_text(
        "{ mode: 'peer', listen: { endpoints: ['tcp/192.0.2.1:7447'] },"
        " scouting: { multicast: { enabled: false } } }",
        encoding="utf-8",
    )
    with (
        open_session(Endpoints(file, listen=(locator,))),
        plain_session(locator) as session,
    ):
        until(lambda: session.info.peers_zid())


def test_processes_of_one_machine_meet_without_options(
    stack: ExitStack, locator: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(session, "MEETING_PLACE", locator)

    def joined() -> ZenohMedium:
        medium = ZenohMedium("machine")
        stack.callback(medium.close)
        return medium

    seen: list[tuple[str, bool]] = []
    first, second, third = joined(), joined(), joined()
    third.watch("", lambda name, present: seen.append((name, present)))
    second.announce("second")
    first.announce("first")
    until(lambda: len(seen) == 2)
    # The first one listened at the meeting place: the others continue, and are found.
    first.close()
    until(lambda: ("first", False) in seen)
    joined().announce("fourth")
    until(lambda: ("fourth", True) in seen)
    assert ("second", False) not in seen


SITE = """
{{ mode: "router", listen: {{ endpoints: ["tls/{place}"] }},
  scouting: {{ multicast: {{ enabled: false }} }},
  transport: {{ link: {{ tls: {{ root_ca_certificate: "{folder}/site.pem", enable_mtls: true,
    listen_certificate: "{folder}/router.pem", listen_private_key: "{folder}/router.key" }} }} }},
  access_control: {{ enabled: true, default_permission: "deny",
    rules: [ {{ id: "system", permission: "allow", flows: ["ingress", "egress"],
      messages: ["put", "delete", "declare_subscriber", "query", "reply", "declare_queryable",
        "liveliness_token", "liveliness_query", "declare_liveliness_subscriber"],
      key_exprs: ["ours/**"] }} ],
    subjects: [ {{ id: "robots", cert_common_names: ["robot"] }} ],
    policies: [ {{ rules: ["system"], subjects: ["robots"] }} ] }} }}
"""
MEMBER = """
{{ mode: "client", connect: {{ endpoints: ["tls/{place}"] }},
  scouting: {{ multicast: {{ enabled: false }} }},
  transport: {{ link: {{ tls: {{ root_ca_certificate: "{folder}/site.pem", enable_mtls: true,
    connect_certificate: "{folder}/{name}.pem",
    connect_private_key: "{folder}/{name}.key" }} }} }} }}
"""


def certify(folder: Path, *names: str) -> None:
    """Generate keys and certificates of a site."""
    openssl = shutil.which("openssl")
    if openssl is None:
        pytest.skip("openssl is not installed")
    key = ["-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes"]
    alternative = "subjectAltName=DNS:localhost,IP:127.0.0.1"

    def make(name: str, *more: str) -> None:
        command = [openssl, "req", "-x509", *key, "-keyout", f"{name}.key"]
        command += ["-out", f"{name}.pem", "-days", "2", "-subj", f"/CN={name}"]
        subprocess.run([*command, *more], cwd=folder, check=True, capture_output=True)

    make("site")
    for name in names:
        leaf = ["-addext", alternative, "-addext", "basicConstraints=critical,CA:FALSE"]
        make(name, *leaf, "-CA", "site.pem", "-CAkey", "site.key")


def test_files_of_zenoh_encrypt_and_keep_strangers_out(
    stack: ExitStack, tmp_path: Path
) -> None:
    certify(tmp_path, "router", "robot", "stranger")
    place = f"127.0.0.1:{free_port()}"

    def file(text: str, name: str) -> Path:
        made = tmp_path / f"{name}.json5"
        text = text.format(place=place, folder=tmp_path.as_posix(), name=name)
        made.write_text(text, encoding="utf-8")
        return made

    stack.enter_context(open_session(Endpoints(file(SITE, "router"))))

    def joined(name: str, system: str) -> ZenohMedium:
        made = ZenohMedium(system, Endpoints(file(MEMBER, name)))
        stack.callback(made.close)
        return made

    seen: list[tuple[str, str]] = []
    members = [joined("robot", "ours"), joined("robot", "ours")]
    others = [joined("stranger", "ours"), joined("robot", "theirs")]
    for medium, who in ((members[0], "member"), (others[0], "stranger")):
        medium.watch("", lambda name, _, who=who: seen.append((who, name)))
    for medium, name in ((others[0], "a"), (others[1], "b"), (members[1], "c")):
        medium.announce(name)
    until(lambda: len(seen) == 2)
    # Announcements of a stranger are visible to the stranger alone.
    assert sorted(seen) == [("member", "c"), ("stranger", "a")]


EXPIRED = """
[ca]
default_ca = site
[site]
database = index.txt
new_certs_dir = .
serial = serial
default_md = sha256
policy = policy
x509_extensions = leaf
[policy]
commonName = supplied
[leaf]
basicConstraints = critical,CA:FALSE
"""


def expire(folder: Path, name: str) -> None:
    """Replace a certificate of the site by one that has expired."""
    (folder / "expired.cnf").write_text(EXPIRED, encoding="ascii")
    (folder / "index.txt").touch()
    (folder / "serial").write_text("01", encoding="ascii")
    request = ["openssl", "req", "-new", "-key", f"{name}.key", "-subj", f"/CN={name}"]
    sign = ["openssl", "ca", "-batch", "-notext", "-config", "expired.cnf"]
    sign += ["-cert", "site.pem", "-keyfile", "site.key", "-in", "request.csr"]
    sign += ["-startdate", "20200101000000Z", "-enddate", "20210101000000Z"]
    for command in ([*request, "-out", "request.csr"], [*sign, "-out", f"{name}.pem"]):
        subprocess.run(command, cwd=folder, check=True, capture_output=True)


def test_certificates_that_a_site_does_not_accept(
    stack: ExitStack, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    certify(tmp_path, "router", "robot", "old")
    expire(tmp_path, "old")
    for name in ("site.key", "site.pem"):
        shutil.copy(tmp_path / name, tmp_path / f"ours.{name}")
    certify(tmp_path, "foreign")  # by a new certificate of another site
    for name in ("site.key", "site.pem"):
        shutil.copy(tmp_path / f"ours.{name}", tmp_path / name)
    shutil.copy(tmp_path / "robot.pem", tmp_path / "lost.pem")  # without its key
    place = f"127.0.0.1:{free_port()}"

    def file(text: str, name: str) -> Path:
        made = tmp_path / f"{name}.json5"
        text = text.format(place=place, folder=tmp_path.as_posix(), name=name)
        made.write_text(text, encoding="utf-8")
        return made

    stack.enter_context(open_session(Endpoints(file(SITE, "router"))))
    shown = MEMBER.partition(", enable_mtls")[0] + " }} }} }} }}"
    refused = "Unable to connect"
    for text, name, reason in (
        (MEMBER, "old", refused),
        (MEMBER, "foreign", refused),
        (MEMBER, "lost", r"connect_private_key: \S+lost\.key"),
        (shown, "none", refused),
    ):
        with pytest.raises(MediumError, match=reason):
            ZenohMedium("ours", Endpoints(file(text, name)))
    ZenohMedium("ours", Endpoints(file(MEMBER, "robot"))).close()
    options = ["--clock", "real", "--transport", "zenoh", "--until", "0.1"]
    options += ["--transport-config", str(tmp_path / "old.json5")]
    assert rtgen(["run", str(SYSTEM), *options]) == 3
    assert "expired ones" in capfd.readouterr().err


@pytest.mark.random
def test_garbage_at_the_port_harms_nobody(stack: ExitStack, locator: str) -> None:
    """Octets that are not Zenoh's, and its greeting cut off and changed, also half open."""
    first = ZenohMedium("plain", Endpoints(listen=(locator,)))
    a = stack.enter_context(Process(first, "a"))
    second = ZenohMedium("plain", Endpoints(connect=(locator,), listen=(_any(),)))
    b = stack.enter_context(Process(second, "b"))
    connector = b.connect("a.out", "b.in")
    a.connect("a.out", "b.in")
    for process in (a, b):
        process.ready()
    out, node = a.node("a").out, b.node("b")
    until(lambda: out.write(sample(-1)) is not None and node.take())
    host, _, port = locator.removeprefix("tcp/").rpartition(":")
    greeting = recorded_greeting()
    for number, case in enumerate(cases(60)):
        drawn = random.Random(case)
        octets = bytearray(greeting)
        for _ in range(drawn.randrange(4)):
            octets[drawn.randrange(len(octets))] = drawn.randrange(256)
        choice = drawn.randrange(4)
        if choice == 0:
            octets = bytearray(drawn.randbytes(drawn.choice((1, 2, 100, 70_000))))
        elif choice == 1:
            octets = octets[: drawn.randrange(len(octets))]
        with suppress(ConnectionError):
            strange = socket.create_connection((host, int(port)))
            stack.callback(strange.close)
            with nullcontext() if drawn.random() < 0.3 else strange:
                strange.sendall(octets)
        out.write(sample(number))
        until(lambda number=number: node.take()[-1] == number)
    arrived = [each for each in node.received if each >= 0]
    assert arrived == [*map(float, range(number + 1))]
    assert connector.lost == connector.arrivals.doubles == 0


def recorded_greeting() -> bytes:
    """Return what a session sends first to one that does not answer."""
    with socket.create_server(("127.0.0.1", 0)) as door:
        place = f"tcp/127.0.0.1:{door.getsockname()[1]}"
        config = Endpoints(connect=(place,), listen=(_any(),))
        with open_session(config), door.accept()[0] as client:
            client.settimeout(PATIENCE)
            return client.recv(4096)


# The command.


@pytest.mark.parametrize(
    ("options", "code", "text"),
    [
        (["--transport", "zenoh"], 2, "--transport zenoh needs --clock real"),
        (["--connect", "tcp/127.0.0.1:1"], 2, "--connect needs --transport zenoh"),
        (
            ["--clock", "real", "--transport", "zenoh", "--listen", "here"],
            2,
            "'here' is not PROTOCOL/ADDRESS",
        ),
        (
            ["--clock", "real", "--transport", "zenoh", "--listen", "tcp/192.0.2.1:1"],
            3,
            "hint: an address of this machine with a free port",
        ),
        (
            ["--clock", "real", "--transport", "zenoh", "--connect", "tcp/127.0.0.1:1"],
            3,
            "hint: start the router, or correct its address",
        ),
    ],
)
def test_options_that_do_not_fit(
    options: list[str], code: int, text: str, capfd: pytest.CaptureFixture[str]
) -> None:
    assert rtgen(["run", str(SYSTEM), *options, "--until", "0.1"]) == code
    assert text in capfd.readouterr().err


def test_a_session_cannot_keep_a_shorter_lease_than_its_own(
    stack: ExitStack, locator: str
) -> None:
    place = (locator,)
    qos = Qos(lease=0.5)
    first = ZenohMedium("s", Endpoints(listen=place))
    stack.callback(first.close)
    with pytest.raises(MediumError, match=r"x/out: a lease of 0\.5 s .* is 3 s"):
        first.publisher(Topic("x/out", TimedDouble), qos)
    second = ZenohMedium("s", Endpoints(connect=place, lease=0.5))
    stack.callback(second.close)
    second.publisher(Topic("x/out", TimedDouble), qos).close()


@pytest.mark.sampled(0)
def test_a_process_that_stands_still_is_lost_after_the_lease_of_a_connection(
    stack: ExitStack, tmp_path: Path, locator: str
) -> None:
    """The default lease would exceed the duration of the test."""
    file = tmp_path / "zenoh.json5"
    file.write_text(
        "{ mode: 'peer', listen: { endpoints: [] },"
        " scouting: { multicast: { enabled: false } },"
        " transport: { link: { tx: { lease: 100000000 } } } }",
        encoding="utf-8",
    )
    watcher = ZenohMedium("rh3_goal", Endpoints(file, listen=(locator,)))
    stack.callback(watcher.close)
    options = ["zenoh", "--connect", locator, "--transport-config", str(file)]
    run = Run(tmp_path, options, CONSOLE, system=leased(tmp_path, 0.5))
    stack.callback(run.kill)
    seen: list[bool] = []
    watcher.watch("PositionInput0/", lambda _, present: seen.append(present))
    until(lambda: seen)
    run.process.send_signal(signal.SIGSTOP)
    until(lambda: len(seen) > 1)
    assert seen == [True, False]


def test_a_peer_connects_to_another_one_that_appears_later_and_returns(
    stack: ExitStack, locator: str
) -> None:
    early = ZenohMedium("s", Endpoints(connect=(locator,), listen=(_any(),)))
    stack.callback(early.close)
    seen: list[bool] = []
    early.watch("", lambda _, present: seen.append(present))
    for count in (1, 2):
        with closing(ZenohMedium("s", Endpoints(listen=(locator,)))) as late:
            late.announce("late")
            until(lambda count=count: seen.count(True) == count)
        until(lambda count=count: seen.count(False) == count)


@pytest.fixture
def start(tmp_path: Path, locator: str) -> Iterator[Callable[..., Run]]:
    runs: list[Run] = []

    def started(only: str, *more: str) -> Run:
        runs.append(Run(tmp_path, ["zenoh", "--connect", locator], only, *more))
        return runs[-1]

    yield started
    for run in runs:
        run.kill()


@pytest.mark.nightly
def test_rh3_in_three_processes_behind_a_router_survives_the_loss_of_one(
    start: Callable[..., Run], stack: ExitStack, locator: str
) -> None:
    """The controlling process is killed while the wheels turn: they stop until it is back."""
    stack.enter_context(media.router(locator))
    wheels = Wheels()
    watch = stack.enter_context(plain_session(locator))
    for key, heard in (
        ("*/topic/RefHardRh30/out/OutWheelAngle/*", wheels.on_angles),
        ("*/topic/PathFollower0/out/velocity/*", wheels.on_command),
    ):

        def on_sample(
            each: zenoh.Sample, heard: Callable[[bytes], None] = heard
        ) -> None:
            heard(each.payload.to_bytes())

        watch.declare_subscriber(key, on_sample)
    robot, way = start(ROBOT), start(WAY)
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
    found: Any = re.findall(r"final pose +\((\S+), (\S+), (\S+)\)", output)
    [pose] = found
    assert abs(float(pose[0]) - GOAL[0]) < 0.05
    assert abs(float(pose[1]) - GOAL[1]) < 0.05


class EagerSession:
    """A session with a query that waits for its queryable."""

    def declare_queryable(self, key: str, on_query: Any, *, complete: bool) -> Any:
        query = SimpleNamespace(payload=None)
        on_query(query)
        return SimpleNamespace(undeclare=lambda: None)

    def liveliness(self) -> Any:
        token = SimpleNamespace(undeclare=lambda: None)
        return SimpleNamespace(declare_token=lambda key: token)

    def is_closed(self) -> bool:
        return False


def test_a_request_that_comes_while_its_service_is_declared_is_served() -> None:
    requests: list[bytes] = []
    session: Any = EagerSession()
    service = ZenohService(session, "s", lambda octets, _: requests.append(octets))
    assert requests == [b""]
    service.close()
