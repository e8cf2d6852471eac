"""Messages that no editor sends: headers, lengths and bodies that are wrong or without end."""

from __future__ import annotations

import io
import json
import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from lsprotocol.types import TextDocumentContentChangeWholeDocument
from patience import PATIENCE

from rtgen.tools.lsp import documents
from rtgen.tools.lsp.documents import Documents, path_of
from rtgen.tools.lsp.messages import (
    MAX_BODY,
    MAX_HEADER,
    MAX_VALUES,
    FramingError,
    Messages,
)
from rtgen.tools.lsp.server import make_server

PARSE_ERROR, INVALID_REQUEST, UNKNOWN_METHOD = -32700, -32600, -32601
INVALID_PARAMS, NOT_INITIALIZED = -32602, -32002


def message(body: bytes | dict[str, Any]) -> bytes:
    data = body if isinstance(body, bytes) else json.dumps(body).encode()
    return b"Content-Length: %d\r\n\r\n" % len(data) + data


def request(number: Any, method: Any, params: Any = None) -> bytes:
    text = {"jsonrpc": "2.0", "id": number, "method": method, "params": params}
    return message(text)


def notice(method: str, params: Any = None) -> bytes:
    return message({"jsonrpc": "2.0", "method": method, "params": params})


INITIALIZE: dict[str, Any] = {"processId": None, "rootUri": None, "capabilities": {}}
START = request("start", "initialize", INITIALIZE) + notice("initialized", {})
END = request("end", "shutdown") + notice("exit")
HERE = {"textDocument": {"uri": "file:///a.idl"}}
HOVER = {**HERE, "position": {"line": 0, "character": 0}}


class Sent(io.BytesIO):
    """What a server has sent, which closes its stream."""

    def close(self) -> None:
        """Keep the stream open."""


def answers(octets: bytes) -> list[tuple[Any, int | None]]:
    """Return the id of each answer with its error code."""
    parts = re.split(rb"Content-Length: \d+\r\n\r\n", octets)
    received = [json.loads(part) for part in parts if part]
    return [
        (each["id"], each.get("error", {}).get("code"))
        for each in received
        if "method" not in each
    ]


def served(sent: bytes) -> list[tuple[Any, int | None]]:
    """Return the answers of a server to octets, without the first and the last one."""
    output = Sent()
    make_server().start_io(io.BytesIO(START + sent + END), output)
    first, *others, last = answers(output.getvalue())
    assert (first, last) == (("start", None), ("end", None))
    return others


BROKEN = {
    "no length": b"Content-Type: x\r\n\r\n{}",
    "no fields": b"\r\n{}",
    "negative": b"Content-Length: -2\r\n\r\n{}",
    "a word": b"Content-Length: two\r\n\r\n{}",
    "other digits": "Content-Length: \u0662\r\n\r\n{}".encode(),
    "many digits": b"Content-Length: " + b"9" * 5_000 + b"\r\n\r\n{}",
    "beyond sizes": b"Content-Length: 99999999999999999999\r\n\r\n{}",
    "four gigabytes": b"Content-Length: 4000000000\r\n\r\n{}",
    "two lengths": b"Content-Length: 2\r\nContent-Length: 3\r\n\r\n{}",
    "no colon": b"GET / HTTP/1.1\r\n\r\n",
    "cut-off line": b"Content-Len",
    "cut-off header": b"Content-Length: 2\r\n",
    "cut-off body": b'Content-Length: 500\r\n\r\n{"jsonrpc"',
    "long line": b"X: " + b"a" * 10_000_000,
    "many lines": b"".join(b"X%d: a\r\n" % n for n in range(100_000)),
    "zeros": bytes(10_000_000),
    "octets": bytes(range(256)) * 1_000,
}


@pytest.mark.sampled(7)
@pytest.mark.parametrize("kind", BROKEN)
def test_the_server_ends_where_no_message_can_be_found(kind: str) -> None:
    output = Sent()
    with pytest.raises(FramingError) as raised:
        make_server().start_io(io.BytesIO(START + BROKEN[kind]), output)
    assert answers(output.getvalue()) == [("start", None)]
    assert len(str(raised.value)) < 200
    assert str(raised.value).isprintable()


REFUSED = {
    "empty": (b"Content-Length: 0\r\n\r\n", [(None, INVALID_REQUEST)]),
    "cut-off JSON": (message(b'{"id":'), [(None, PARSE_ERROR)]),
    "arrays": (message(b"[" * 200_000), [(None, PARSE_ERROR)]),
    "objects": (message(b'{"a":' * 200_000), [(None, PARSE_ERROR)]),
    "no UTF-8": (message(b'{"method":"\x83\x5c"}'), [(None, PARSE_ERROR)]),
    "other charset": (
        b"Content-Length: 2\r\nContent-Type: text; charset=shift_jis\r\n\r\n{}",
        [(None, INVALID_REQUEST)],
    ),
    "a list": (message(b"[]"), [(None, INVALID_REQUEST)]),
    "a number": (message(b"1"), [(None, INVALID_REQUEST)]),
    "null": (message(b"null"), [(None, INVALID_REQUEST)]),
    "an empty object": (message(b"{}"), [(None, INVALID_REQUEST)]),
    "neither": (message({"jsonrpc": "2.0"}), [(None, INVALID_REQUEST)]),
    "old version": (
        message({"jsonrpc": "1.0", "id": 7, "method": "shutdown"}),
        [(7, INVALID_REQUEST)],
    ),
    "odd id": (request({}, "shutdown"), [(None, INVALID_REQUEST)]),
    "odd method": (request(7, {}), [(7, INVALID_REQUEST)]),
    "unknown method": (request(7, "nonsense"), [(7, UNKNOWN_METHOD)]),
    "no parameters": (
        message({"jsonrpc": "2.0", "id": 7, "method": "nonsense"}),
        [(7, UNKNOWN_METHOD)],
    ),
    "second start": (request(7, "initialize", INITIALIZE), [(7, INVALID_REQUEST)]),
    "deep parameters": (
        request(7, "textDocument/hover", json.loads('{"a":' * 500 + "1" + "}" * 500)),
        [(7, INVALID_PARAMS)],
    ),
    "too many values": (
        message(b"[" + b"0," * MAX_VALUES + b"0]"),
        [(None, INVALID_REQUEST)],
    ),
    "too long": (message(bytes(MAX_BODY + 1)), [(None, INVALID_REQUEST)]),
    "cancelled nothing": (notice("$/cancelRequest", {"id": {}}), []),
    "cancelled without": (notice("$/cancelRequest"), []),
    "odd response": (message({"jsonrpc": "2.0", "id": 7, "error": 5}), []),
    "unasked response": (message({"jsonrpc": "2.0", "id": [], "result": 5}), []),
}


@pytest.mark.sampled(6)
@pytest.mark.parametrize("kind", REFUSED)
def test_a_wrong_message_is_answered_and_the_next_ones_are_served(
    kind: str, caplog: pytest.LogCaptureFixture
) -> None:
    sent, expected = REFUSED[kind]
    assert served(sent) == expected
    own = [r for r in caplog.records if r.name.startswith("rtgen")]
    assert [r.getMessage() for r in own if "Internal" in r.getMessage()] == []


def test_fields_of_a_header_have_any_case_and_order() -> None:
    body = request(7, "nonsense").partition(b"\r\n\r\n")[2]
    for header in (
        b"content-length: %d\r\nContent-Type: a; charset=utf-8\r\n\r\n",
        b"X-Other: a: b\r\nCONTENT-LENGTH:%d\r\n\r\n",
        b'Content-Type: a; charset="UTF8"\r\nContent-Length: %d\n\n',
    ):
        assert served(header % len(body) + body) == [(7, UNKNOWN_METHOD)]


def test_requests_before_the_first_and_after_the_last_are_refused() -> None:
    output = Sent()
    opened = notice(
        "textDocument/didOpen",
        {
            "textDocument": {
                "uri": "file:///a.idl",
                "languageId": "idl",
                "version": 1,
                "text": "struct S {",
            }
        },
    )
    early = opened + request(1, "textDocument/hover", HOVER) + request(2, "shutdown")
    late = request(3, "textDocument/hover", HOVER) + opened
    whole = early + START + request("end", "shutdown") + late + notice("exit")
    make_server().start_io(io.BytesIO(whole), output)
    assert answers(output.getvalue()) == [
        (1, NOT_INITIALIZED),
        (2, NOT_INITIALIZED),
        ("start", None),
        ("end", None),
        (3, INVALID_REQUEST),
    ]


NOTIFICATIONS = {
    *("initialized", "$/cancelRequest", "$/setTrace", "window/workDoneProgress/cancel"),
    *(f"textDocument/did{name}" for name in ("Open", "Change", "Close", "Save")),
    *(f"notebookDocument/did{name}" for name in ("Open", "Change", "Close")),
    "workspace/didChangeConfiguration",
    "workspace/didChangeWatchedFiles",
    "workspace/didChangeWorkspaceFolders",
}

VALUES: tuple[Any, ...] = (
    *(None, 5, -1.5, "x", [], {}, {"textDocument": None}, {"query": 7}),
    {"textDocument": {"uri": 5, "version": "x", "languageId": 3, "text": 9}},
    {**HERE, "position": {"line": "a", "character": None}, "range": 5, "context": 0},
    {**HERE, "position": {"line": 2**70, "character": -(2**70)}, "newName": 7},
    {"event": None, "changes": 5, "settings": [], "contentChanges": 5},
    {**HERE, "contentChanges": [{"range": {}, "text": "x"}, {"text": 5}, 7, None]},
)


@pytest.mark.sampled(0)
def test_every_method_with_parameters_of_other_kinds() -> None:
    features = make_server().protocol.fm
    methods = sorted({*features.features, *features.builtin_features})
    served_methods = [m for m in methods if m not in ("initialize", "shutdown", "exit")]
    assert len(served_methods) > 25
    calls = [(method, value) for method in served_methods for value in VALUES]
    sent = b"".join(request(n, *call) for n, call in enumerate(calls))
    sent += b"".join(notice(*call) for call in calls)
    received = dict(served(sent))
    assert sorted(received) == list(range(len(calls)))
    for number, code in received.items():
        allowed = INVALID_REQUEST if calls[number][0] in NOTIFICATIONS else None
        assert code in (allowed, INVALID_PARAMS), calls[number]
    assert set(received.values()) == {None, INVALID_PARAMS, INVALID_REQUEST}


class Endless(io.RawIOBase):
    """A stream that repeats a piece without end, and counts what is read."""

    def __init__(self, start: bytes, piece: bytes) -> None:
        self.start, self.piece = start, piece
        self.total = self.most = 0

    def readline(self, size: int | None = -1, /) -> bytes:
        assert size is not None
        assert size >= 0, "a line without limit"
        line, self.start = (self.start or self.piece * size)[:size], self.start[size:]
        end = line.find(b"\n") + 1
        if end:
            line, self.start = line[:end], line[end:] + self.start
        self.total += len(line)
        return line

    def read(self, size: int = -1, /) -> bytes:
        self.total += size
        self.most = max(self.most, size)
        if self.total > 1 << 40:
            return b""
        return bytes(size)


@pytest.mark.parametrize("piece", [b"\0", b"a", b"X: a\r\n", b"a: b", b":\n"])
def test_a_header_is_read_up_to_a_limit(piece: bytes) -> None:
    stream = Endless(b"", piece)
    messages = Messages(stream)  # type: ignore[arg-type]
    assert messages.readline() == b""
    assert messages.problem is not None
    assert stream.total <= MAX_HEADER + len(piece)


def test_the_rest_of_a_long_body_is_not_stored() -> None:
    stream = Endless(b"Content-Length: %d\r\n\r\n" % (MAX_BODY * 40), b"")
    messages = Messages(stream)  # type: ignore[arg-type]
    length = int(messages.readline().split()[1])
    assert messages.readline() == b"\r\n"
    assert json.loads(messages.read(length)).startswith("the message has more than")
    assert stream.most <= MAX_BODY


@pytest.mark.sampled(3)
@pytest.mark.parametrize(
    "uri",
    [
        "file:///" + "n" * 5_000 + ".idl",
        "file:///" + "n/" * 1_000_000 + "a.idl",
        "file:///" + "%ff" * 300 + ".idl",
        "file:///a%00b.idl",
        "file://[::1/a.idl",
        "file:///\ud800.idl",
        "untitled:a.idl",
    ],
)
def test_an_address_that_no_file_has_is_no_document(uri: str) -> None:
    assert path_of(uri) is None
    item = {"uri": uri, "languageId": "idl", "version": 1, "text": "struct S {"}
    asked = {"textDocument": {"uri": uri}}
    sent = notice("textDocument/didOpen", {"textDocument": item})
    sent += request(1, "textDocument/documentSymbol", asked)
    sent += notice("textDocument/didClose", asked)
    assert served(sent) == [(1, None)]


@pytest.mark.sampled(1)
@pytest.mark.skipif(sys.platform == "win32", reason="limits of a process are of POSIX")
@pytest.mark.parametrize(
    "sent", [b"Content-Length: 99999999999999999999\r\n\r\n", bytes(100)]
)
def test_the_command_ends_in_one_line(tmp_path: Path, sent: bytes) -> None:
    script = 'ulimit -d 500000; exec "$0" -m rtgen lsp'
    done = subprocess.run(
        ["sh", "-c", script, sys.executable],
        cwd=tmp_path,
        env={**os.environ, "NO_COLOR": "1"},
        input=START + sent,
        capture_output=True,
        timeout=PATIENCE,
        check=False,
    )
    assert done.returncode == 3
    first, hint, count = done.stderr.decode().splitlines()
    assert first.startswith("error[ENV0001]: the input is not of the Language Server")
    assert (hint[:7], count) == ("  hint:", "1 error")


def test_open_documents_together_have_a_limit(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(documents, "MAX_OPEN", 250)
    opened = Documents()
    uris = [f"file:///no/such/{n}.idl" for n in range(3)]
    assert [opened.open(uri, 1, "/" * 100) is not None for uri in uris] == [
        *(True, True),
        False,
    ]
    assert opened.open(uris[0], 2, "/" * 150) is not None
    whole = TextDocumentContentChangeWholeDocument("/" * 101)
    assert opened.change(uris[1], 2, [whole]) is None
    assert opened.of(uris[1]) is None
    assert opened.open(uris[2], 1, "/" * 100) is not None
