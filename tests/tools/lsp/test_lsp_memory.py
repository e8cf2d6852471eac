"""Memory of the server while a document is edited: nothing of earlier texts is kept."""

from __future__ import annotations

import asyncio
import gc
import weakref
from collections.abc import Iterator
from pathlib import Path

import pytest
from editor import Editor

from rtgen.compiler.frontends.idl.names.tables import Tables
from rtgen.tools.lsp import server as lsp_server
from rtgen.tools.lsp.documents import uri_of

EDITS = 12
PATIENCE = 60.0
"""Time-out for all analyses [s], reached only if the server hangs."""


@pytest.fixture(autouse=True)
def _without_automatic_collections() -> Iterator[None]:
    """Those of the server are enough."""
    enabled = gc.isenabled()
    gc.disable()
    yield
    gc.unfreeze()
    if enabled:
        gc.enable()


@pytest.mark.sampled(0)
def test_edits_leave_nothing_behind(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    editor = Editor(tmp_path, types_idl="struct Old { long first; };\n")
    monkeypatch.chdir(tmp_path)
    path = str(editor.path("types_idl"))
    texts: list[weakref.ref[object]] = []

    async def session() -> None:
        server = lsp_server.make_server()
        published = asyncio.Event()
        monkeypatch.setattr(server, "publish", lambda *_: published.set())
        documents = server.files.documents
        documents.open(uri_of(path), 1, "struct S { long member; };\n")
        for number in range(EDITS):
            document = documents.at(path)
            assert document is not None
            texts.append(weakref.ref(document.text))
            del document
            server.schedule(server.files.key_of(path), 0)
            await published.wait()
            published.clear()
            view = server.files.view(uri_of(path))
            assert view is not None
            change = lsp_server.types.TextDocumentContentChangePartial(
                view.range(0, 0), f"struct S{number} {{ long member; }};\n"
            )
            del view
            documents.change(uri_of(path), number + 2, [change])
        analysis = server.files.analysis(path)
        assert analysis is not None
        assert analysis.index.definition(f"idl S{EDITS - 2}") is not None
        assert analysis.index.definition(f"idl S{EDITS - 1}") is None
        document = documents.at(path)
        assert document is not None
        shift = document.shift_from(analysis.texts["specs/types.idl"])
        assert shift.forward(0, 6) == (27 + len(str(EDITS)), 33 + len(str(EDITS)))
        server.abort()

    asyncio.run(asyncio.wait_for(session(), PATIENCE))
    assert sum(text() is not None for text in texts) <= 1
    gc.unfreeze()
    tables = [each for each in gc.get_objects() if type(each) is Tables]
    assert not tables, "only names and declarations remain of a translation unit"
