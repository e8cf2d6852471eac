"""Client, marshaller and communication RTCs with the generated server, over real sockets."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import pytest
from boards import MOTOR, SERVER, emit, imported, joined, write

from rtgen.runtime import (
    ERROR_STATE,
    RTC_OK,
    SECOND,
    ConnectionLimitError,
    RealClock,
    System,
)
from rtgen.runtime.marshalling.descriptors import (
    PrimitiveDescriptor,
    SequenceDescriptor,
)
from rtgen.runtime.opaque_rpc import (
    E_BOVR,
    E_OBJ,
    E_RPC,
    ERCD,
    MERCD,
    SERCD,
    ExchangeChannel,
    PacketServer,
    RpcError,
    TcpServer,
)
from rtgen.runtime.opaque_rpc.communication import OpaqueRpcCommunication
from rtgen.runtime.values import AnyValue


@pytest.fixture(scope="module")
def modules(tmp_path_factory: pytest.TempPathFactory) -> Iterator[dict[str, Any]]:
    folder = tmp_path_factory.mktemp("boards")
    files = {
        "server.cdl": joined(SERVER, "sServer"),
        "board.cdl": joined(MOTOR, "nBoard::sMotor"),
        "anys.cdl": joined(MOTOR, "nBoard::sMotor", options="array=any,tdr=little"),
    }
    emission, _ = emit(folder, files)
    write(folder, emission.artifacts)
    names = (
        "robots.tecs.server.server_marshaller",
        "robots.tecs.server.server_server",
        "nodes.server_client",
        "robots.tecs.board.motor_marshaller",
        "robots.tecs.board.motor_server",
        "robots.tecs.board._types",
        "robots.tecs.board.nboard",
        "robots.tecs.anys.motor_marshaller",
        "robots.tecs.anys.motor_server",
        "robots.tecs.anys._types",
        "robots.tecs.anys.nboard",
    )
    with imported(folder, *names) as found:
        yield dict(zip(names, found, strict=True))


WAIT = 10.0
"""Time-out of a test that hangs [s]."""


class Pipeline:
    """A client, a marshaller and a communication RTC, joined and active."""

    def __init__(self, modules: dict[str, Any], stem: str, name: str) -> None:
        marshaller = modules[f"robots.tecs.{stem}.{name.lower()}_marshaller"]
        client = {
            "server": modules["nodes.server_client"].ServerClient,
            "board": modules["robots.tecs.board.motor_marshaller"].MotorClientBase,
            "anys": modules["robots.tecs.anys.motor_marshaller"].MotorClientBase,
        }[stem]
        self.system = System(RealClock(), check_values="always")
        self.marshaller = getattr(marshaller, f"{name}Marshaller")("Marshaller0")
        self.link = OpaqueRpcCommunication("Communication0")
        self.components = [self.link, self.marshaller]
        self.client = client("Client0")
        self.components.append(self.client)
        for component in self.components:
            self.system.add(component, 1000.0)
        ends = ("Marshaller0", "communication"), ("Communication0", "service")
        self.system.connect(*ends)
        port = name.lower()
        self.system.connect(("Client0", port), ("Marshaller0", port))

    def to(self, port: int) -> Any:
        """Return the service, once all are ACTIVE and connected with the board at that port."""
        self.link.configuration_sets.set("port", str(port))
        self.link.configuration_sets.set("timeout", "0.5")
        for component in self.components:
            assert self.system.activate(component.instance_name) is RTC_OK
        self.run_until(lambda: all(c.is_active for c in self.components))
        (consumer,) = self.client.consumers.values()
        return consumer.object

    def run_until(self, condition: Callable[[], bool]) -> None:
        limit = self.system.time + int(WAIT * SECOND)
        assert self.system.run(limit, lambda _: condition())


@pytest.fixture
def pipeline(modules: dict[str, Any]) -> Iterator[Callable[[str, str], Pipeline]]:
    made = []

    def make(stem: str, name: str) -> Pipeline:
        made.append(Pipeline(modules, stem, name))
        return made[-1]

    yield make
    for each in made:
        each.link.on_deactivated(0)
        each.system.close()


@contextmanager
def serving(unmarshaller: Any) -> Iterator[int]:
    """Yield the port of a board."""
    server = TcpServer(unmarshaller)
    server.start()
    try:
        yield server.address[1]
    finally:
        server.close()


def server_board(modules: dict[str, Any], first: int = 0) -> Any:
    module = modules["robots.tecs.server.server_server"]

    class Board(module.ServerTarget):  # type: ignore[name-defined, misc]
        def func1(self, indata: int) -> int:
            return indata + first

        def func2(self) -> tuple[int, int]:
            return 0, ord("x")

        def func3(self, indata: int, iodata: int) -> tuple[int, int]:
            return indata % 1000, iodata + 1

    return module.ServerUnmarshaller(Board())


def motor_board(modules: dict[str, Any], stem: str = "board") -> Any:
    module = modules[f"robots.tecs.{stem}.motor_server"]
    types = modules[f"robots.tecs.{stem}._types"]

    class Board(module.MotorTarget):  # type: ignore[name-defined, misc]
        stopped: list[int] = []  # noqa: RUF012

        def set(
            self, level: int, sign: int, text: bytes, raw: list[int], n: int
        ) -> int:
            assert (level, sign, text, raw, n) == (-5, -1, b"ab\xff", [-1, 2, -128], 3)
            return 1

        def get(self) -> int:
            return -7

        def state(self, given: Any) -> tuple[int, Any]:
            given.sign -= 1
            given.raw = [value + 1 for value in given.raw]
            given.data = [-1, -2]
            given.count = 2
            return 0, given

        def maybe(
            self, in8: int | None, letter: int | None, point: Any, out32: bool
        ) -> tuple[int, int | None, int | None]:
            received = (in8 is not None) + (letter is not None) + (point is not None)
            return received, letter, 77 if out32 else None

        def names(
            self, list_: list[str], n: int, wide: list[int], marks: list[int] | None
        ) -> tuple[int, str]:
            received = "" if marks is None else str(marks)
            return n, "+".join(list_) + "".join(map(chr, wide)) + received

        def part(self, points: list[Any], n: int) -> tuple[int, Any, list[bool]]:
            total = types.nBoard_tagPoint(
                sum(p.x for p in points), sum(p.y for p in points)
            )
            return n, total, [True, False, True]

        def wide(self, grid: list[bytes]) -> tuple[int, bytes]:
            return sum(map(sum, grid)), b"lab\xe9"

        def stop(self, why: int) -> None:
            self.stopped.append(why)

        def stop_all(self) -> None:
            self.stopped.append(-1)

        def bytes_(self, *given: Any) -> tuple[int, Any, int | None]:
            assert given[2:4] == (-1, 5)
            return 0, given[0], given[5]

        def list_(self, handlers: int) -> None:
            self.stopped.append(handlers)

        def __init___(self) -> None:
            self.stopped.append(-2)

        def class_(self, *values: int) -> int:
            return sum(values)

    return module.MotorUnmarshaller(Board())


def test_figure_8(
    modules: dict[str, Any], pipeline: Callable[[str, str], Pipeline]
) -> None:
    with serving(server_board(modules)) as port:
        service = pipeline("server", "Server").to(port)
        assert service.func1(-3) == -3
        assert service.func2() == (0, "x")
        assert service.func3(-1, 4_000_000_000) == (999, 4_000_000_001)


def test_values_in_the_view_of_idl(
    modules: dict[str, Any], pipeline: Callable[[str, str], Pipeline]
) -> None:
    board = motor_board(modules)
    idl = modules["robots.tecs.board.nboard"]
    with serving(board) as port:
        service = pipeline("board", "Motor").to(port)
        assert service.set(-5, 255, "ab\xff", b"\xff\x02\x80", 3) == 1
        assert service.get() == -7
        given = idl.tagState(
            level=-3,
            sign=255,
            code="\xe9",
            label="abc\x00",
            raw=b"\xff\x00\x7f",
            grid=[b"abc", b"def"],
            nick="nick",
            at=idl.tagPoint(1, 2),
            data=b"\x80",
            count=1,
        )
        assert service.state(given) == (
            0,
            idl.tagState(
                level=-3,
                sign=254,
                code="\xe9",
                label="abc\x00",
                raw=b"\x00\x01\x80",
                grid=[b"abc", b"def"],
                nick="nick",
                at=idl.tagPoint(1, 2),
                data=b"\xff\xfe",
                count=2,
            ),
        )
        assert service.maybe(b"", "", []) == (0, "", [77])
        point = idl.tagPoint(1, 2)
        assert service.maybe(b"\xff", "q", [point]) == (3, "q", [77])
        assert service.names(["a", "b"], 2, [0x3042], []) == (ERCD(E_RPC, E_BOVR), "")
        assert service.names(["a", "b"], 2, [0xE9], []) == (2, "a+b\xe9")
        assert service.names(["a", ""], 2, [], [b"\xff\x02"]) == (2, "a+[-1, 2]")
        points = [idl.tagPoint(1, 2), idl.tagPoint(3, 4)]
        assert service.part(points, 2) == (2, idl.tagPoint(4, 6), [True, False, True])
        assert service.wide([b"\x01\x02\x03", b"\xff\x00\x00"]) == (261, "lab\xe9")
        assert service.class_(1, 2, 3, 4) == 10
        point = idl.tagPoint(1, 2)
        found = service.bytes(point, point, 255, b"\x05", 3, b"\x09")
        assert found == (0, point, b"\x09")
        service.list(4)
        service.stop("s")
        assert service.stop_all() == 0
        assert service.get() == -7
    assert board.target.stopped == [4, ord("s"), -1]


def test_arrays_as_any(
    modules: dict[str, Any], pipeline: Callable[[str, str], Pipeline]
) -> None:
    point = modules["robots.tecs.anys.nboard"].tagPoint
    sequence = SequenceDescriptor(PrimitiveDescriptor("octet"))
    text = SequenceDescriptor(PrimitiveDescriptor("char"))
    with serving(motor_board(modules, "anys")) as port:
        service = pipeline("anys", "Motor").to(port)
        values = AnyValue(text, "ab\xff"), AnyValue(sequence, b"\xff\x02\x80")
        assert service.set(-5, 255, *values, 3) == 1
        points = AnyValue(SequenceDescriptor(point._descriptor_), [point(1, 2)])
        assert service.part(points, 1)[2].value == [True, False, True]


def test_no_board(
    modules: dict[str, Any], pipeline: Callable[[str, str], Pipeline]
) -> None:
    with serving(server_board(modules)) as port:
        pass
    code = pipeline("server", "Server").to(port).func1(1)
    assert (MERCD(code), SERCD(code)) == (E_RPC, E_OBJ)
    with pytest.raises(RpcError) as caught:
        pipeline("board", "Motor").to(port).get()
    assert caught.value.sub == E_OBJ


def test_no_communication_rtc(
    modules: dict[str, Any], pipeline: Callable[[str, str], Pipeline]
) -> None:
    joined = pipeline("server", "Server")
    service = joined.to(1)
    joined.system.disconnect("Marshaller0.communication_Communication0.service")
    assert service.func2() == (service.func1(1), "\x00")
    assert SERCD(service.func1(1)) == E_OBJ


def test_the_active_set_is_switched_at_run_time(
    modules: dict[str, Any], pipeline: Callable[[str, str], Pipeline]
) -> None:
    with (
        serving(server_board(modules, 100)) as first,
        serving(server_board(modules, 200)) as second,
    ):
        joined = pipeline("server", "Server")
        service = joined.to(first)
        assert service.func1(1) == 101
        sets = joined.link.configuration_sets
        sets.set("port", str(second), "mode2")
        joined.system.activate_set("Communication0", "mode2")
        joined.run_until(lambda: joined.link.config.port == str(second))
        joined.run_until(lambda: service.func1(1) == 201)


def test_a_second_marshaller_is_refused(
    modules: dict[str, Any], pipeline: Callable[[str, str], Pipeline]
) -> None:
    joined = pipeline("server", "Server")
    other = modules["robots.tecs.board.motor_marshaller"].MotorMarshaller("Other0")
    joined.system.add(other)
    ends = ("Other0", "communication"), ("Communication0", "service")
    with pytest.raises(ConnectionLimitError, match="at most 1"):
        joined.system.connect(*ends)
    joined.system.disconnect("Marshaller0.communication_Communication0.service")
    assert joined.system.connect(*ends)


@pytest.mark.parametrize(
    ("parameter", "text", "reason"),
    [
        ("type", "UDP", "type is 'UDP'"),
        ("port", "none", "port is 'none'"),
        ("port", "65536", "at most 65535"),
        ("ipaddr", "none", "ipaddr names no address"),
    ],
)
def test_settings_that_tell_no_channel(
    modules: dict[str, Any],
    pipeline: Callable[[str, str], Pipeline],
    parameter: str,
    text: str,
    reason: str,
) -> None:
    joined = pipeline("server", "Server")
    joined.link.configuration_sets.set(parameter, text)
    joined.system.activate("Communication0")
    joined.run_until(lambda: joined.system.state("Communication0") is ERROR_STATE)
    assert reason in joined.link.reason


def test_proxies_need_no_rtcs(modules: dict[str, Any]) -> None:
    channel = ExchangeChannel(PacketServer(motor_board(modules)))
    proxy = modules["robots.tecs.board.motor_marshaller"].MotorProxy(channel)
    assert proxy.maybe(-1, None, None, False) == (1, None, None)
    assert proxy.maybe(None, 255, None, True) == (1, 255, 77)
    with pytest.raises(ValueError, match="3 are needed"):
        proxy.set(0, 0, b"", [], 3)
