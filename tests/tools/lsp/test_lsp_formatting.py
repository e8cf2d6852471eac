"""Formatting in the server: in a thread, which ends when its result is not wanted any more."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Awaitable, Callable
from pathlib import Path

import pytest
from lsprotocol import types
from patience import PATIENCE
from pygls.exceptions import JsonRpcException

from rtgen.tools.lsp.analysis import SupersededError
from rtgen.tools.lsp.features.formatting import formatting
from rtgen.tools.lsp.server import Server, make_server
from rtgen.tools.lsp.workspace import View

LOOSE = "struct  S { long  a; };\n"


class Slow:
    """Formatting that takes place when it is allowed to."""

    def __init__(self) -> None:
        self.started = asyncio.Event()
        self.allowed = threading.Event()
        self.ended = threading.Event()
        self._loop = asyncio.get_running_loop()

    def __call__(
        self, view: View, range_: types.Range | None, check: Callable[[], None]
    ) -> list[types.TextEdit]:
        self._loop.call_soon_threadsafe(self.started.set)
        try:
            assert self.allowed.wait(PATIENCE)
            return formatting(view, range_, check)
        finally:
            self.ended.set()


def session(
    folder: Path,
    monkeypatch: pytest.MonkeyPatch,
    use: Callable[[Server, types.TextDocumentIdentifier, Slow], Awaitable[None]],
) -> None:
    """Use a server in which a document is being formatted."""

    async def body() -> None:
        slow = Slow()
        monkeypatch.setattr("rtgen.tools.lsp.server.formatting", slow)
        uri = (folder / "a.idl").as_uri()
        server = make_server()
        server.files.documents.open(uri, 1, LOOSE)
        await use(server, types.TextDocumentIdentifier(uri), slow)
        assert slow.ended.wait(PATIENCE)

    asyncio.run(asyncio.wait_for(body(), PATIENCE))


def test_the_server_answers_while_it_formats(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def use(
        server: Server, document: types.TextDocumentIdentifier, slow: Slow
    ) -> None:
        task = asyncio.create_task(server.formatted(document, None))
        await slow.started.wait()
        assert server.view(document) is not None
        assert not task.done()
        slow.allowed.set()
        [first, *_] = await task
        assert first.new_text == "struct S { long a; };\n"

    session(tmp_path, monkeypatch, use)


@pytest.mark.parametrize("change", ["edit", "close", "shutdown"])
def test_formatting_ends_when_the_document_is_another_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, change: str
) -> None:
    async def use(
        server: Server, document: types.TextDocumentIdentifier, slow: Slow
    ) -> None:
        task = asyncio.create_task(server.formatted(document, None))
        await slow.started.wait()
        documents = server.files.documents
        if change == "edit":
            whole = types.TextDocumentContentChangeWholeDocument(LOOSE)
            documents.change(document.uri, 2, [whole])
        elif change == "close":
            documents.close(document.uri)
        else:
            server.abort()
        slow.allowed.set()
        with pytest.raises(JsonRpcException) as raised:
            await task
        assert raised.value.code == types.LSPErrorCodes.ContentModified.value

    session(tmp_path, monkeypatch, use)


def test_formatting_ends_when_its_request_is_cancelled(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    checks = []

    async def use(
        server: Server, document: types.TextDocumentIdentifier, slow: Slow
    ) -> None:
        def watched(
            view: View, range_: types.Range | None, check: Callable[[], None]
        ) -> list[types.TextEdit]:
            checks.append(check)
            return slow(view, range_, check)

        monkeypatch.setattr("rtgen.tools.lsp.server.formatting", watched)
        task = asyncio.create_task(server.formatted(document, None))
        await slow.started.wait()
        task.cancel()
        with pytest.raises(asyncio.CancelledError):
            await task
        slow.allowed.set()

    session(tmp_path, monkeypatch, use)
    [check] = checks
    with pytest.raises(SupersededError):
        check()
