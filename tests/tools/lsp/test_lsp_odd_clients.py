"""Invalid messages of clients: the server, as a process, answers each request."""

from __future__ import annotations

import io
import json
import re
import subprocess
import sys
import threading
from asyncio import BaseEventLoop
from pathlib import Path
from typing import Any

import pytest
from patience import PATIENCE
from projects import PROJECT

from rtgen.tools.lsp.server import make_server

NO_CLIENT = -32803, -32602, -32601
"""Error codes for refusals: the request failed, invalid parameters, unknown method."""

CONTENT_MODIFIED = -32801
"""Error code for a document that was edited or closed while it was formatted."""

REQUEST_CANCELLED = -32800
"""A rename is worked out beside the analyses, so a request for one can be cancelled."""

POSITIONS = (
    {"line": 0, "character": 4},  # between the units of a character
    {"line": 0, "character": 400},
    {"line": 9999, "character": 0},
    {"line": 4294967295, "character": 4294967295},
    {"line": -1, "character": -1},
    {"line": 3, "character": 11},
)
ADDRESSES = (
    *("untitled:Untitled-1", "git:/a/b.idl", "file:///", "file:///tmp", "", "x"),
    *("file://host/share/a.idl", "file:///no/such.idl", "file:///tmp/%00.idl"),
    *("file:///%ff%fe.idl", "file:///c%3A/a.idl", "file:///no/rtgen.toml"),
)


class Script:
    """The messages of a client, sent without waiting for answers."""

    def __init__(self, *folders: Path) -> None:
        self.messages: list[dict[str, Any]] = []
        self.requests = 0
        workspace = [{"uri": f.as_uri(), "name": f.name} for f in folders]
        self.ask(
            "initialize",
            processId=None,
            rootUri=None,
            workspaceFolders=workspace,
            capabilities={},
        )
        self.notify("initialized")

    def notify(self, method: str, **parameters: Any) -> None:
        self.messages.append({"method": method, "params": parameters})

    def ask(self, method: str, **parameters: Any) -> int:
        self.requests += 1
        message = {"id": self.requests, "method": method, "params": parameters}
        self.messages.append(message)
        return self.requests

    def open(self, uri: str, text: str) -> None:
        item = {"uri": uri, "languageId": "idl", "version": 1, "text": text}
        self.notify("textDocument/didOpen", textDocument=item)

    def change(self, uri: str, version: int, *changes: dict[str, Any]) -> None:
        document = {"uri": uri, "version": version}
        self.notify(
            "textDocument/didChange",
            textDocument=document,
            contentChanges=list(changes),
        )

    def close(self, uri: str) -> None:
        self.notify("textDocument/didClose", textDocument={"uri": uri})

    def all_requests(self, uri: str, position: dict[str, int]) -> None:
        """Add each request of all features."""
        document = {"uri": uri}
        there = {"textDocument": document, "position": position}
        range_ = {"start": position, "end": position}
        options = {"tabSize": 2, "insertSpaces": True}
        for name in ("hover", "definition", "completion", "prepareRename"):
            self.ask(f"textDocument/{name}", **there)
        self.ask("textDocument/documentHighlight", **there)
        context = {"includeDeclaration": True}
        self.ask("textDocument/references", **there, context=context)
        self.ask("textDocument/rename", **there, newName="X")
        for name in ("documentSymbol", "semanticTokens/full", "foldingRange"):
            self.ask(f"textDocument/{name}", textDocument=document)
        inside = {"textDocument": document, "range": range_}
        self.ask("textDocument/semanticTokens/range", **inside)
        self.ask("textDocument/inlayHint", **inside)
        self.ask("textDocument/codeAction", **inside, context={"diagnostics": []})
        self.ask("textDocument/rangeFormatting", **inside, options=options)
        self.ask("textDocument/formatting", textDocument=document, options=options)

    def bytes(self) -> bytes:
        """Return the messages, and a request to shut down, as they are sent."""
        self.ask("shutdown")
        self.notify("exit")
        sent = b""
        for message in self.messages:
            body = json.dumps({"jsonrpc": "2.0", **message}).encode()
            sent += b"Content-Length: %d\r\n\r\n" % len(body) + body
        return sent

    def run(self, folder: Path) -> tuple[list[dict[str, Any]], str]:
        """Return the messages of a server that receives the script at once, and its log."""
        command = [sys.executable, "-m", "rtgen", "lsp"]
        done = subprocess.run(
            command,
            cwd=folder,
            input=self.bytes(),
            capture_output=True,
            timeout=60,
            check=True,
        )
        parts = re.split(rb"(?:Content-[\w-]+: [^\r]+\r\n)+\r\n", done.stdout)
        return [json.loads(part) for part in parts if part], done.stderr.decode()


class Answers(io.BytesIO):
    """The stream of a client that is closed when an analysis has just ended."""

    def __init__(self, ended: threading.Event) -> None:
        super().__init__()
        self.ended = ended

    def close(self) -> None:
        assert self.ended.wait(PATIENCE)
        super().close()


def project(folder: Path, *, settings: bool = True) -> Path:
    (folder / "specs").mkdir(parents=True)
    if settings:
        (folder / "rtgen.toml").write_text('[sources]\npaths = ["specs"]\n')
    for name, text in PROJECT.items():
        stem, _, suffix = name.rpartition("_")
        (folder / "specs" / f"{stem}.{suffix}").write_text(text)
    return folder


def odd_session(folder: Path) -> Script:
    one, two = project(folder / "one"), project(folder / "two \u00fc")
    bare = project(folder / "bare", settings=False)
    script = Script(one, two)
    types = (one / "specs" / "types.idl").as_uri()
    script.open(types, "// \U0001f916\U0001f916\n" + PROJECT["types_idl"])
    for position in POSITIONS:
        script.all_requests(types, position)
    files = [
        path for path in sorted((one / "specs").iterdir()) if path.suffix != ".idl"
    ]
    files += [two / "specs" / "types.idl", bare / "specs" / "drawing.idl"]
    for path in (*files, one / "rtgen.toml"):
        script.open(path.as_uri(), path.read_text().replace("\n", "\r\n"))
        script.all_requests(path.as_uri(), POSITIONS[-1])
    outside = (folder / "gone" / "new.idl").as_uri()
    script.open(outside, "\ufeffstruct New { Missing a; };\r")
    script.all_requests(outside, POSITIONS[0])
    for uri in ADDRESSES:
        script.open(uri, "struct S {")
        script.all_requests(uri, POSITIONS[0])
        script.change(uri, 2, {"text": "struct T { long a; };"})
        script.close(uri)
    backwards = {
        "start": {"line": 5, "character": 9},
        "end": {"line": 2, "character": 1},
    }
    halved = {"start": {"line": 0, "character": 4}, "end": {"line": 0, "character": 6}}
    script.change(types, 7, {"range": backwards, "text": "x"})
    script.change(types, 3, {"range": halved, "text": "\ud83e"})
    script.change(types, 8)
    script.change("file:///never/opened.idl", 8, {"text": "a"})
    document = {"uri": types}
    number = script.ask(
        "textDocument/hover", textDocument=document, position=POSITIONS[-1]
    )
    for cancelled in (number, 9999, "x"):
        script.notify("$/cancelRequest", id=cancelled)
    script.all_requests("file:///never/opened.idl", POSITIONS[-1])
    for method in ("textDocument/hover", "textDocument/nonsense", "nonsense"):
        script.ask(method)
        script.ask(method, textDocument=5, position="x")
        script.notify(method, a=1)
    script.notify("textDocument/didChange")
    script.notify("$/nonsense")
    folders = {"added": [{"uri": bare.as_uri(), "name": "b"}], "removed": []}
    script.notify("workspace/didChangeWorkspaceFolders", event=folders)
    gone = [{"uri": "file:///gone/x.idl", "type": 3}]
    script.notify("workspace/didChangeWatchedFiles", changes=gone)
    script.ask("workspace/symbol", query="\ud83e")
    script.close(types)  # during its analysis
    script.close(types)
    return script


@pytest.mark.sampled(0)
def test_odd_clients(tmp_path: Path) -> None:
    script = odd_session(tmp_path)
    received, log = script.run(tmp_path)
    assert "Traceback" not in log
    assert "Internal Error" not in log
    answers = [message for message in received if "method" not in message]
    assert sorted(a["id"] for a in answers) == list(range(1, script.requests + 1))
    codes = {a["error"]["code"] for a in answers if "error" in a}
    assert codes - {CONTENT_MODIFIED, REQUEST_CANCELLED} == set(NO_CLIENT)


@pytest.mark.sampled(0)
def test_exit_as_an_analysis_ends(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    call_soon, ended = BaseEventLoop.call_soon_threadsafe, threading.Event()

    def observed(*arguments: Any, **options: Any) -> Any:
        handle = call_soon(*arguments, **options)
        if threading.current_thread().name.startswith("analysis"):
            ended.set()  # The loop publishes the findings next.
        return handle

    monkeypatch.setattr(BaseEventLoop, "call_soon_threadsafe", observed)
    one = project(tmp_path)
    script = Script(one)
    types = one / "specs" / "types.idl"
    script.open(types.as_uri(), types.read_text())
    make_server().start_io(io.BytesIO(script.bytes()), Answers(ended))
    assert ended.is_set()
    assert caplog.messages == []
