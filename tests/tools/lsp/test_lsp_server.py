"""The server as a process, driven by a client library over standard input and output."""

from __future__ import annotations

import asyncio
import sys
from collections.abc import Awaitable, Callable
from pathlib import Path

import pytest
from lsprotocol import types
from projects import PROJECT
from pytest_lsp import LanguageClient, make_test_lsp_client

from rtgen.cli import run

PATIENCE = 60.0
"""Time-out for an answer [s], reached only if the server hangs."""


def project(folder: Path) -> dict[str, Path]:
    (folder / "specs").mkdir()
    (folder / "rtgen.toml").write_text('[sources]\npaths = ["specs"]\n')
    paths = {}
    for name, text in PROJECT.items():
        stem, _, suffix = name.rpartition("_")
        paths[name] = folder / "specs" / f"{stem}.{suffix}"
        paths[name].write_text(text, encoding="utf-8")
    return paths


def in_session(
    folder: Path, use: Callable[[LanguageClient], Awaitable[None]], *encodings: str
) -> None:
    """Start a server, use it, and end it as an editor does."""

    async def session() -> None:
        client = make_test_lsp_client()
        await client.start_io(sys.executable, "-m", "rtgen", "lsp", cwd=folder)
        await client.initialize_session(
            types.InitializeParams(
                capabilities=types.ClientCapabilities(
                    general=types.GeneralClientCapabilities(
                        position_encodings=[*encodings] or None
                    )
                ),
                root_uri=folder.as_uri(),
            )
        )
        try:
            await use(client)
        finally:
            await client.shutdown_session()
            await client.stop()

    asyncio.run(asyncio.wait_for(session(), PATIENCE))


def opened(
    client: LanguageClient, path: Path, text: str
) -> types.TextDocumentIdentifier:
    client.text_document_did_open(
        types.DidOpenTextDocumentParams(
            types.TextDocumentItem(path.as_uri(), "idl", 1, text)
        )
    )
    return types.TextDocumentIdentifier(path.as_uri())


async def findings(
    client: LanguageClient, uri: str, *, errors: bool
) -> list[types.Diagnostic]:
    """Return the findings of a document, once it has errors, or none any more."""
    while True:
        found = client.diagnostics.get(uri)
        if found is not None:
            severities = {d.severity for d in found}
            if (types.DiagnosticSeverity.Error in severities) is errors:
                return [*found]
        await asyncio.sleep(0.02)


def test_a_session(tmp_path: Path) -> None:
    paths = project(tmp_path)

    async def use(client: LanguageClient) -> None:
        path = paths["types_idl"]
        text = "// \U0001f916\n" + PROJECT["types_idl"].replace(
            "octet quality;", "/* \U0001f916 */ octett quality;"
        )
        document = opened(client, path, text)
        found = await findings(client, document.uri, errors=True)
        wrong = [d for d in found if d.severity is types.DiagnosticSeverity.Error]
        assert [d.code for d in wrong] == ["IDL0200"]
        # The robot has two units of UTF-16, and is one character.
        assert wrong[0].range == types.Range(
            types.Position(6, 13), types.Position(6, 19)
        )
        actions = await client.text_document_code_action_async(
            types.CodeActionParams(
                document, wrong[0].range, types.CodeActionContext([wrong[0]])
            )
        )
        assert actions is not None
        edit = actions[0].edit
        assert edit is not None
        assert edit.changes is not None
        change = edit.changes[document.uri][0]
        assert change.new_text == "octet"
        client.text_document_did_change(
            types.DidChangeTextDocumentParams(
                types.VersionedTextDocumentIdentifier(version=2, uri=document.uri),
                [
                    types.TextDocumentContentChangePartial(
                        range=change.range, text=change.new_text
                    )
                ],
            )
        )
        await findings(client, document.uri, errors=False)
        position = types.Position(3, 11)
        hover = await client.text_document_hover_async(
            types.HoverParams(document, position)
        )
        assert hover is not None
        assert isinstance(hover.contents, types.MarkupContent)
        assert "struct Shapes::Point" in hover.contents.value
        with pytest.raises(Exception, match="is a keyword of IDL"):
            await client.text_document_rename_async(
                types.RenameParams(document, position, "struct")
            )
        places = await client.text_document_references_async(
            types.ReferenceParams(types.ReferenceContext(True), document, position)
        )
        assert places is not None
        assert {Path(p.uri).name for p in places} == {
            "types.idl",
            "drawing.idl",
            "system.xml",
        }

    in_session(tmp_path, use)


@pytest.mark.sampled(0)
def test_a_client_that_counts_octets(tmp_path: Path) -> None:
    paths = project(tmp_path)

    async def use(client: LanguageClient) -> None:
        text = "/* \U0001f916 */ struct A { Missing b; };\n"
        document = opened(client, paths["types_idl"], text)
        found = await findings(client, document.uri, errors=True)
        places = [d.range.start.character for d in found if d.code == "IDL0200"]
        assert places == [len(text.partition("Missing")[0].encode())]

    in_session(tmp_path, use, "utf-8", "utf-16")


def test_help_has_an_example(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["lsp", "--help"]) == 0
    assert "Example: rtgen lsp" in capsys.readouterr().out
