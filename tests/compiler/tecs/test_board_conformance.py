"""`rtgen conformance FILE.cdl`: rtgen's boards pass, and violations fail their check."""

from __future__ import annotations

import errno
import logging
import os
import socket
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from json_schemas import valid

from rtgen.cli import run
from rtgen.runtime.opaque_rpc import (
    E_PAR,
    More,
    ProtocolError,
    TcpServer,
    make_tdr,
)
from rtgen.tools.conformance.board import board as board_module
from rtgen.tools.conformance.board.board import BoardUnderTest
from rtgen.tools.conformance.board.checks import CHECKS
from rtgen.tools.conformance.board.testing import checked
from rtgen.tools.conformance.check import Permission
from rtgen.tools.conformance.report import Report, Verdict
from rtgen.tools.rpc.board import MockBoard
from rtgen.tools.rpc.codecs import Service
from rtgen.tools.rpc.signatures import CdlFiles, Peer, Wire

pytestmark = pytest.mark.waits

CDL = """signature sBench {
    ER move( [in] int32_t speed, [in] double64_t gain );
    ER fill( [in,size_is(count,4)] const int16_t *data, [in] uint8_t count, [out] int32_t *sum );
    ER label( [in,string(8)] const char_t *text );
    ER maybe( [in,nullable] const int32_t *value, [out,nullable] int32_t *other );
    [oneway] void halt( [in] int32_t reason );
    int32_t total( void );
};
"""
ANSWER, QUIET = 3.0, 0.05
"""Time-out of a board, and the time after which it has nothing to add [s]."""
START, TWO_WAY, ONEWAY = b"\x67\x2a", b"\x5a\x3c", b"\x6d\x5e"
PEER = Peer(Wire(make_tdr("network"), "tecsgen"), ANSWER)
FILLED = 12
"""Octets of the reply of fill."""
MOVE, FILL, LABEL, MAYBE, HALT = range(1, 6)


def service(folder: Path, text: str = CDL) -> Service:
    file = folder / "bench.cdl"
    file.write_text(text)
    return CdlFiles(file).service("sBench", PEER.wire)


@contextmanager
def served(board: MockBoard, patience: float = 4 * ANSWER) -> Iterator[tuple[str, int]]:
    """Yield a board at a port, whose log is silent; `patience` for the rest of a request."""
    logging.disable()
    try:
        with TcpServer(board, "127.0.0.1", 0, patience) as server:
            yield server.address
    finally:
        logging.disable(logging.NOTSET)


class Proxy:
    """Stands between a client and a board, one connection after another.

    `request` changes the client's data, None ends the connection; `reply` changes the answers,
    `instead` answers for the board. `most` connections are accepted; `begin` is called for each.
    """

    def __init__(
        self,
        board: tuple[str, int],
        request: Callable[[bytes], bytes | None] = lambda data: data,
        reply: Callable[[bytes], bytes] = lambda data: data,
        instead: Callable[[bytes], bytes | None] = lambda data: None,
        most: int = 1 << 30,
        begin: Callable[[], None] = lambda: None,
    ) -> None:
        self._board, self._request, self._reply = board, request, reply
        self._instead, self._most, self._begin = instead, most, begin
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.address: tuple[str, int] = self._listener.getsockname()
        self._thread = threading.Thread(target=self._accept)
        self._thread.start()

    def close(self) -> None:
        """Accept no more connections."""
        shut(self._listener)
        self._thread.join()
        self._listener.close()

    def _accept(self) -> None:
        for _ in range(self._most):
            try:
                client, _ = self._listener.accept()
            except OSError:
                return
            self._begin()
            with client, socket.create_connection(self._board) as board:
                back = threading.Thread(target=self._back, args=(board, client))
                back.start()
                self._there(client, board)
                back.join()
        shut(self._listener)

    def _there(self, client: socket.socket, board: socket.socket) -> None:
        try:
            while data := client.recv(4096):
                if (own := self._instead(data)) is not None:
                    client.sendall(own)
                    continue
                changed = self._request(data)
                if changed is None:
                    break
                board.sendall(changed)
        except OSError:
            pass  # The other end has closed, which the threads see at their own ends.
        for end in (board, client):
            shut(end)

    def _back(self, board: socket.socket, client: socket.socket) -> None:
        try:
            while data := board.recv(4096):
                client.sendall(self._reply(data))
        except OSError:
            pass  # As above.
        shut(client)


def shut(end: socket.socket) -> None:
    try:
        end.shutdown(socket.SHUT_RDWR)
    except OSError:
        return


def report_of(
    address: tuple[str, int],
    expected: Service,
    *,
    actuate: bool,
    stall: float | None = None,
) -> Report:
    board = BoardUnderTest(
        expected, expected.functions, address, None, 115200, ANSWER, QUIET, stall
    )
    return checked(
        board, "sBench", "bench.cdl", [Permission.ACTUATE] if actuate else []
    )


def failed(report: Report) -> list[str]:
    return [o.check for o in report.outcomes if o.verdict is Verdict.FAILED]


def test_a_board_of_ours_passes_every_check(tmp_path: Path) -> None:
    expected = service(tmp_path)
    with served(MockBoard(expected), 1.0) as address:
        report = report_of(address, expected, actuate=True, stall=4 * ANSWER)
    assert [(o.check, o.verdict, o.problems) for o in report.outcomes] == [
        (check.name, Verdict.PASSED, ()) for check in CHECKS
    ]
    assert all(outcome.tried for outcome in report.outcomes)


def test_a_board_that_needs_a_moment_until_it_listens_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Refuses each connection twice, as a server of tecsgen does after the one before."""
    attempts = 0
    connect = socket.create_connection

    def late(address: tuple[str, int], timeout: float) -> socket.socket:
        nonlocal attempts
        attempts += 1
        if attempts % 3:
            raise ConnectionRefusedError(errno.ECONNREFUSED, "Connection refused")
        return connect(address, timeout)

    expected = service(tmp_path)
    with served(MockBoard(expected), 1.0) as address:
        monkeypatch.setattr(board_module.socket, "create_connection", late)
        report = report_of(address, expected, actuate=True, stall=4 * ANSWER)
    assert report.passed
    assert attempts > 30
    assert Verdict.SKIPPED not in {o.verdict for o in report.outcomes}


def test_no_function_is_called_without_permission(tmp_path: Path) -> None:
    expected, called = service(tmp_path), list[str]()
    with served(MockBoard(expected, print_call=called.append)) as address:
        report = report_of(address, expected, actuate=False)
    assert called == []
    assert report.passed
    assert [o.check for o in report.outcomes if o.verdict is Verdict.SKIPPED] == [
        check.name
        for check in CHECKS
        if check.needs is not None or check.name == "request.stalled"
    ]


def refusing(
    number: int, bad: Callable[[tuple[object, ...]], bool]
) -> Callable[[MockBoard, Service], None]:
    """Return a board that refuses calls of a function with some arguments."""

    def change(board: MockBoard, known: Service) -> None:
        head = known.codec.request_head(number)
        right = board.handlers[head]
        [function] = [
            f for f in known.functions.values() if f.layout.function.id == number
        ]

        def wrong(more: More) -> bytes | None:
            taken = bytearray()

            def noting(n: int) -> bytes:
                data = more(n)
                taken.extend(data)
                return data

            reply = right(noting)
            if bad(function.decode_request(head + bytes(taken))):
                raise ProtocolError(E_PAR, "not this one")
            return reply

        board.handlers = {**board.handlers, head: wrong}

    return change


def unchanged(board: MockBoard, known: Service) -> None:
    """Return an unchanged board."""


def number_of(data: bytes) -> int:
    return int.from_bytes(data[2:4], "big")


def answering(odd: Callable[[bytes], bool]) -> Callable[[bytes], bytes | None]:
    """Answer requests that a board must not answer."""
    return lambda data: b"\x56\x1e\0\0\0\0\x6d\x5e" if odd(data) else None


def mended(data: bytes) -> bytes:
    """Return a request with the end of two-way functions."""
    whole = data[:2] == START and 1 <= number_of(data) <= 6 and len(data) > 5
    return data[:-2] + TWO_WAY if whole and number_of(data) != HALT else data


def in_one_piece(data: bytes) -> bytes | None:
    return data if len(data) > 3 else None


def backwards(data: bytes) -> bytes:
    """Return several requests in one piece in reverse order."""
    requests = [START + rest for rest in data.split(START)[1:]]
    return b"".join(requests[::-1]) if len(requests) > 2 else data


class LosesTheNext:
    """Ends the connection of the call that follows a call with a wrong start."""

    def __init__(self) -> None:
        self.is_confused = False

    def __call__(self, data: bytes) -> bytes | None:
        if data[:4] == b"\0\0\0\6":
            self.is_confused = True
        elif self.is_confused and data[:4] == START + b"\0\6":
            self.is_confused = False
            return None
        return data


class AfterMany:
    """Ends a connection after many requests."""

    def __init__(self) -> None:
        self.begin()

    def begin(self) -> None:
        self.count = 0

    def __call__(self, data: bytes) -> bytes | None:
        self.count = self.count + 1 if number_of(data) == 6 else 0
        return None if self.count > 50 else data


MUTANTS: dict[str, tuple[Callable[[MockBoard, Service], None], dict[str, object]]] = {
    "request.start": (
        unchanged,
        {
            "instead": answering(
                lambda data: data[:2] != START and data[2:] == b"\x7f\xfe"
            )
        },
    ),
    "function.unknown": (
        unchanged,
        {"instead": answering(lambda data: data[:2] == START and number_of(data) == 0)},
    ),
    "request.end": (unchanged, {"request": mended}),
    "request.recovery": (unchanged, {"request": LosesTheNext()}),
    "request.segments": (unchanged, {"request": in_one_piece}),
    "call.order": (unchanged, {"request": backwards}),
    "call.reply": (
        unchanged,
        {"reply": lambda data: data + b"\0" if len(data) == FILLED else data},
    ),
    "call.limits": (refusing(MOVE, lambda values: values[0] == (1 << 31) - 1), {}),
    "call.arrays": (refusing(FILL, lambda values: values[1] == 4), {}),
    "call.texts": (refusing(LABEL, lambda values: len(str(values[0])) == 7), {}),
    "call.long-texts": (
        unchanged,
        {"instead": answering(lambda data: data[:8] == START + b"\0\3\0\0\0\x09")},
    ),
    "call.null": (refusing(MAYBE, lambda values: values[0] is None), {}),
    "call.oneway": (
        unchanged,
        {
            "instead": answering(
                lambda data: number_of(data) == HALT and data[-2:] == ONEWAY
            )
        },
    ),
}


@pytest.mark.sampled(5)
@pytest.mark.parametrize("name", MUTANTS)
def test_a_check_fails_for_a_board_that_breaks_just_it(
    name: str, tmp_path: Path
) -> None:
    change, hooks = MUTANTS[name]
    expected = service(tmp_path)
    board = MockBoard(expected)
    change(board, expected)
    with served(board) as address:
        proxy = Proxy(address, **hooks)  # type: ignore[arg-type]
        try:
            report = report_of(proxy.address, expected, actuate=True)
        finally:
            proxy.close()
    assert failed(report) == [name]


def test_an_element_at_its_limit_that_is_refused(tmp_path: Path) -> None:
    expected = service(tmp_path)
    board = MockBoard(expected)
    refusing(FILL, lambda values: values[0] == [0x7FFF])(board, expected)
    with served(board) as address:
        assert failed(report_of(address, expected, actuate=True)) == ["call.limits"]


def test_a_silent_client_that_keeps_others_out(tmp_path: Path) -> None:
    expected = service(tmp_path)
    with served(MockBoard(expected), 600.0) as address:
        report = report_of(address, expected, actuate=False, stall=QUIET)
    assert failed(report) == ["request.stalled"]


def test_calls_that_end_after_many(tmp_path: Path) -> None:
    expected = service(tmp_path)
    with served(MockBoard(expected)) as address:
        many = AfterMany()
        proxy = Proxy(address, many, begin=many.begin)
        try:
            report = report_of(proxy.address, expected, actuate=True)
        finally:
            proxy.close()
    assert failed(report) == ["call.repeated"]
    [outcome] = [o for o in report.outcomes if o.check == "call.repeated"]
    assert outcome.tried == 50


@pytest.mark.parametrize(
    ("change", "names"),
    [
        (("int32_t speed", "int32_t pace"), ["digest"]),
        (("size_is(count,4)", "size_is(count)"), ["digest", "call.long-arrays"]),
    ],
)
def test_a_board_of_another_signature(
    change: tuple[str, str], names: list[str], tmp_path: Path
) -> None:
    expected = service(tmp_path)
    text = CDL.replace(*change)
    with served(MockBoard(service(tmp_path, text))) as address:
        assert failed(report_of(address, expected, actuate=True)) == names


@pytest.mark.parametrize(("after", "name"), [(2, "connections"), (20, "request.cut")])
def test_a_board_that_accepts_no_more_connections(
    after: int, name: str, tmp_path: Path
) -> None:
    expected = service(tmp_path)
    with served(MockBoard(expected)) as address:
        proxy = Proxy(address, most=after)
        try:
            report = report_of(proxy.address, expected, actuate=True)
        finally:
            proxy.close()
    assert failed(report) == [name]
    assert report.outcomes[-1].problems == ("the board accepts no connection any more",)


def test_a_board_that_goes_between_two_checks(tmp_path: Path) -> None:
    """The check that finds no board has failed, and later ones are skipped."""
    expected = service(tmp_path)
    gone = "the board accepts no connection any more"
    with served(MockBoard(expected)) as address:
        proxy = Proxy(
            address, most=7
        )  # Five are of the first check, and two around it.
        try:
            report = report_of(proxy.address, expected, actuate=True)
        finally:
            proxy.close()
    assert failed(report) == ["request.start"]
    assert {o.problems for o in report.outcomes[3:]} == {(gone,)}


def test_a_board_with_oneway_functions_alone(tmp_path: Path) -> None:
    """Nothing is answered, and yet calls do not come faster than the board serves them."""
    parameters = ", ".join(f"[in] int32_t p{n}" for n in range(20))
    expected = service(
        tmp_path, f"signature sBench {{ [oneway] void go( {parameters} ); }};\n"
    )
    with served(MockBoard(expected)) as address:
        report = report_of(address, expected, actuate=True)
    assert failed(report) == []
    [limits] = [o for o in report.outcomes if o.check == "call.limits"]
    assert limits.tried == 40
    reasons = {p for o in report.outcomes for p in o.problems}
    assert "the board accepts no connection any more" not in reasons


def test_a_serial_device_that_is_missing_or_no_board(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("serial")
    service(tmp_path)
    cdl, device = str(tmp_path / "bench.cdl"), tmp_path / "ttyNONE"
    for where, word in ((str(device), "No such file"), ("/dev/null", "")):
        assert run(["conformance", cdl, "--connect", f"serial:{where}"]) == 3
        said = capfd.readouterr()
        assert word in said.err
        assert where in said.err


def test_a_serial_line_without_a_board(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    """Without --actuate nothing is known of a board that does not answer."""
    pytest.importorskip("serial")
    service(tmp_path)
    near, far = os.openpty()
    try:
        where = f"serial:{os.ttyname(far)}"
        command = ["conformance", str(tmp_path / "bench.cdl"), "--connect", where]
        assert run([*command, "--timeout", "0.1"]) == 3
        assert "--actuate" in capfd.readouterr().err
    finally:
        os.close(near)
        os.close(far)


@pytest.mark.nightly
def test_the_command(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    expected = service(tmp_path)
    cdl, page = str(tmp_path / "bench.cdl"), tmp_path / "report.html"
    with served(MockBoard(expected)) as (host, port):
        where = ["--connect", f"tcp:{host}:{port}", "--timeout", str(ANSWER)]
        assert run(["conformance", cdl, *where, "--html", str(page)]) == 0
        assert "sBench at 127.0.0.1" in capfd.readouterr().out
        assert (
            run(
                [
                    "conformance",
                    cdl,
                    *where,
                    "--json",
                    "--actuate",
                    "--function",
                    "total",
                ]
            )
            == 0
        )
        report = valid(capfd.readouterr().out, "conformance.schema.json")
        assert report["passed"]
        assert run(["conformance", cdl, *where, "--function", "nothing"]) == 2
        assert "it has: move, fill" in capfd.readouterr().err
    assert "request.start" in page.read_text()
    assert run(["conformance", cdl, *where]) == 3
    assert run(["conformance", cdl]) == 2
    assert run(["conformance", cdl, "--connect", "can0"]) == 2
