"""The server: routes requests to features, and runs analyses in a thread after edits."""

from __future__ import annotations

import asyncio
import gc
import logging
import sys
import threading
import time
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import suppress
from functools import partial
from typing import Any, BinaryIO, TypeVar, cast

from lsprotocol import types
from pygls.exceptions import JsonRpcException, JsonRpcInternalError
from pygls.lsp.server import LanguageServer

from rtgen.compiler.diagnostics import ToolError
from rtgen.facts.version import __version__
from rtgen.tools.lsp.analysis import SupersededError
from rtgen.tools.lsp.documents import Document, uri_of
from rtgen.tools.lsp.features.code_actions import code_actions
from rtgen.tools.lsp.features.completion import completion
from rtgen.tools.lsp.features.definition import definition
from rtgen.tools.lsp.features.diagnostics import published
from rtgen.tools.lsp.features.folding import folding
from rtgen.tools.lsp.features.formatting import formatting
from rtgen.tools.lsp.features.hover import hover
from rtgen.tools.lsp.features.inlay_hints import inlay_hints
from rtgen.tools.lsp.features.references import highlights, references
from rtgen.tools.lsp.features.rename import prepared, renamed
from rtgen.tools.lsp.features.semantic_tokens import LEGEND, semantic_tokens
from rtgen.tools.lsp.features.symbols import document_symbols, workspace_symbols
from rtgen.tools.lsp.messages import FramingError, Messages
from rtgen.tools.lsp.protocol import Protocol
from rtgen.tools.lsp.workspace import Findings, ProjectKey, View, Workspace
from rtgen.tools.renaming.definitions import RenameError

DEBOUNCE = 0.15
"""Minimum seconds without an edit before a project is analysed; more if analyses take longer."""
MAX_DEBOUNCE = 1.0
IDLE = 0.5
"""Seconds without an edit after an analysis before the back ends run."""

_WATCHED = "idl,inc,cdl,cde,h,eds,dcf,xdd,xdc,toml,xml,yaml,yml"

T = TypeVar("T")

_log = logging.getLogger(__name__)


class Server(LanguageServer):
    """The language server of rtgen. `debounce` is in seconds."""

    protocol: Protocol

    def __init__(self, debounce: float = DEBOUNCE) -> None:
        super().__init__(
            "rtgen",
            __version__,
            text_document_sync_kind=types.TextDocumentSyncKind.Incremental,
            protocol_cls=Protocol,
        )
        self.files = Workspace()
        self._debounce = debounce
        self._timers: dict[ProjectKey, asyncio.TimerHandle] = {}
        self._wanted: dict[ProjectKey, int] = {}
        self._took: dict[ProjectKey, float] = {}
        self._thread = ThreadPoolExecutor(1, thread_name_prefix="analysis")
        self._formatter = ThreadPoolExecutor(1, thread_name_prefix="formatting")
        self._formatting: set[threading.Event] = set()
        self._published: dict[ProjectKey, set[str]] = {}

    def start_io(
        self, stdin: BinaryIO | None = None, stdout: BinaryIO | None = None
    ) -> None:
        """Serve a client until it, or its input, ends. Raises FramingError."""
        messages = Messages(stdin or sys.stdin.buffer)
        super().start_io(cast("BinaryIO", messages), stdout)
        if messages.problem is not None:
            raise FramingError(messages.problem)

    def report_server_error(self, error: Exception, source: Any) -> None:
        """Log an error, which is also the response to the request.

        A feature that rejects a request by an exception is not an error of the server.
        """
        if source is JsonRpcException and not isinstance(error, JsonRpcException):
            self.protocol.refuse(None, error)  # input that is not JSON
        refused = isinstance(error, JsonRpcException) and not isinstance(
            error, JsonRpcInternalError
        )
        level = logging.INFO if refused else logging.ERROR
        _log.log(level, "%s: %s", type(error).__name__, error)

    @property
    def moves_files(self) -> bool:
        """Whether the editor moves files as part of an edit."""
        workspace = self.client_capabilities.workspace
        edits = None if workspace is None else workspace.workspace_edit
        kinds = None if edits is None else edits.resource_operations
        return bool(
            edits is not None
            and edits.document_changes
            and types.ResourceOperationKind.Rename in (kinds or ())
        )

    async def in_background(self, work: Callable[[], T]) -> T:
        """Return the result of work that takes longer, in the thread of analyses."""
        return await asyncio.get_running_loop().run_in_executor(self._thread, work)

    # Analyses

    def schedule(self, key: ProjectKey, delay: float | None = None) -> None:
        """Analyse a project after a pause without edits; a running analysis is aborted."""
        self._wanted[key] = self._wanted.get(key, 0) + 1
        timer = self._timers.pop(key, None)
        if timer is not None:
            timer.cancel()
        if delay is None:
            took = min(self._took.get(key, 0.0), MAX_DEBOUNCE)
            delay = max(self._debounce, took)
        loop = asyncio.get_running_loop()
        self._timers[key] = loop.call_later(delay, self._start, key)

    def abort(self) -> None:
        """Abort the running analysis, those that are scheduled, and formatting."""
        for ended in self._formatting:
            ended.set()
        for key, timer in self._timers.items():
            timer.cancel()
            self._wanted[key] += 1

    def _start(self, key: ProjectKey) -> None:
        def done(findings: Findings | None) -> None:
            self._took[key] = time.monotonic() - begun
            if findings is not None:
                self.publish(key, findings, versions)
            self._timers[key] = asyncio.get_running_loop().call_later(
                IDLE, self._emit, key
            )

        versions = self._versions()
        begun = time.monotonic()
        self._run(key, self.files.analyse, done)

    def _emit(self, key: ProjectKey) -> None:
        def done(findings: Findings | None) -> None:
            if findings is not None:
                self.publish(key, findings, versions)

        versions = self._versions()
        self._run(key, self.files.emit, done)

    def _versions(self) -> dict[str, int]:
        return {d.path: d.version for d in self.files.documents.all}

    def _run(
        self,
        key: ProjectKey,
        work: Callable[[ProjectKey, Callable[[], bool]], Findings | None],
        done: Callable[[Findings | None], None],
    ) -> None:
        """Work on a project in the thread; call `done` unless there was an edit meanwhile."""
        number = self._wanted[key]
        loop = asyncio.get_running_loop()

        def is_superseded() -> bool:
            return self._wanted[key] != number

        def finished(future: Future[Findings | None]) -> None:
            error = future.exception()
            if error is None:
                if not is_superseded():
                    done(future.result())
            elif not isinstance(error, SupersededError):
                _log.error("analysis: %s: %s", type(error).__name__, error)

        def hand_over(future: Future[Findings | None]) -> None:
            with suppress(RuntimeError):  # the server was shut down meanwhile
                loop.call_soon_threadsafe(finished, future)

        def in_thread() -> Findings | None:
            try:
                return work(key, is_superseded)
            finally:
                _collect()

        self._thread.submit(in_thread).add_done_callback(hand_over)

    def publish(
        self,
        key: ProjectKey,
        findings: Findings,
        versions: dict[str, int],
    ) -> None:
        """Publish the diagnostics of a project; files without any are cleared."""
        before = self._published.get(key, set())
        for path in sorted({*findings, *before}):
            document = self.files.documents.at(path)
            if document is not None and versions.get(path) != document.version:
                continue
            diagnostics = published(self.files, path, findings.get(path, []))
            self.text_document_publish_diagnostics(
                types.PublishDiagnosticsParams(
                    uri=uri_of(path) if document is None else document.uri,
                    diagnostics=diagnostics,
                    version=None if document is None else document.version,
                )
            )
        self._published[key] = {
            path for path, diagnostics in findings.items() if diagnostics
        }
        for refresh in self._refreshes():
            refresh(None)

    def _refreshes(self) -> list[Callable[[None], Any]]:
        """Return the requests that make the client refresh tokens and hints, if supported."""
        workspace = self.client_capabilities.workspace
        refreshes: list[Callable[[None], Any]] = []
        if workspace is None:
            return refreshes
        tokens, hints = workspace.semantic_tokens, workspace.inlay_hint
        if tokens is not None and tokens.refresh_support:
            refreshes.append(self.workspace_semantic_tokens_refresh)
        if hints is not None and hints.refresh_support:
            refreshes.append(self.workspace_inlay_hint_refresh)
        return refreshes

    def changed(self, document: Document | None) -> None:
        """Handle a document that was opened or edited."""
        if document is None:
            return
        if document.path.endswith("rtgen.toml"):
            self.files.forget_projects()
        self.schedule(self.files.key_of(document.path))

    async def formatted(
        self, document: types.TextDocumentIdentifier, range_: types.Range | None
    ) -> list[types.TextEdit]:
        """Return the edits that format a document, which are made in a thread.

        They end when the request is cancelled, the document is edited or the server is shut down.
        """
        view = self.view(document)
        if view is None:
            return []
        ended = threading.Event()
        self._formatting.add(ended)

        def check() -> None:
            current = self.files.documents.at(view.document.path)
            if ended.is_set() or current is not view.document:
                raise SupersededError

        loop = asyncio.get_running_loop()
        try:
            return await loop.run_in_executor(
                self._formatter, formatting, view, range_, check
            )
        except SupersededError:
            code = types.LSPErrorCodes.ContentModified.value
            raise JsonRpcException("the document was changed", code) from None
        finally:
            self._formatting.remove(ended)
            ended.set()

    def view(self, document: types.TextDocumentIdentifier) -> View | None:
        """Return a document and its analysis."""
        return self.files.view(document.uri)


def _collect() -> None:
    """Collect garbage of older analyses, whose trees have cycles; exclude the rest from automatic
    collections.

    Automatic collections would traverse all trees, and delay a request by a tenth of a second.
    """
    gc.unfreeze()
    gc.collect()
    gc.freeze()


def make_server(debounce: float = DEBOUNCE) -> Server:
    """Return a server with all features."""
    server = Server(debounce)
    _add_documents(server)
    _add_names(server)
    _add_outlines(server)
    return server


def _add_documents(server: Server) -> None:
    """Register the notifications about documents and files."""

    @server.feature(types.INITIALIZE)
    def initialize(_: types.InitializeParams) -> None:
        # As pygls does, which has negotiated the encoding.
        encoding = types.PositionEncodingKind(server.workspace.position_encoding)
        server.files.documents.encoding = encoding

    @server.feature(types.INITIALIZED)
    def initialized(_: types.InitializedParams) -> None:
        workspace = server.client_capabilities.workspace
        watched = None if workspace is None else workspace.did_change_watched_files
        if watched is not None and watched.dynamic_registration:
            pattern = f"**/*.{{{_WATCHED}}}"
            options = types.DidChangeWatchedFilesRegistrationOptions(
                watchers=[types.FileSystemWatcher(glob_pattern=pattern)]
            )
            registration = types.Registration(
                id="files",
                method=types.WORKSPACE_DID_CHANGE_WATCHED_FILES,
                register_options=options,
            )
            server.client_register_capability(
                types.RegistrationParams(registrations=[registration])
            )

    # A client that shuts the server down accepts no more diagnostics.
    @server.feature(types.SHUTDOWN)
    def shut_down(_: None) -> None:
        server.abort()

    @server.feature(types.EXIT)
    def exited(_: None) -> None:
        server.abort()

    @server.feature(types.TEXT_DOCUMENT_DID_OPEN)
    def opened(params: types.DidOpenTextDocumentParams) -> None:
        item = params.text_document
        document = server.files.documents.open(item.uri, item.version, item.text)
        if document is not None:
            server.schedule(server.files.key_of(document.path), 0)

    @server.feature(types.TEXT_DOCUMENT_DID_CHANGE)
    def changed(params: types.DidChangeTextDocumentParams) -> None:
        document = params.text_document
        server.changed(
            server.files.documents.change(
                document.uri, document.version, params.content_changes
            )
        )

    @server.feature(types.TEXT_DOCUMENT_DID_SAVE)
    def saved(params: types.DidSaveTextDocumentParams) -> None:
        server.changed(server.files.documents.of(params.text_document.uri))

    @server.feature(types.TEXT_DOCUMENT_DID_CLOSE)
    def closed(params: types.DidCloseTextDocumentParams) -> None:
        document = server.files.documents.close(params.text_document.uri)
        if document is None:
            return
        key = server.files.key_of(document.path)
        if key.file:  # no other project reports them
            server.text_document_publish_diagnostics(
                types.PublishDiagnosticsParams(document.uri, [])
            )
        else:
            server.schedule(key)

    @server.feature(types.WORKSPACE_DID_CHANGE_WATCHED_FILES)
    def watched(_: types.DidChangeWatchedFilesParams) -> None:
        server.files.forget_projects()
        for key in server.files.open_projects():
            server.schedule(key)

    @server.feature(types.WORKSPACE_DID_CHANGE_CONFIGURATION)
    def configured(_: types.DidChangeConfigurationParams) -> None:
        """Ignore settings of the client: rtgen.toml contains them."""


def _add_names(server: Server) -> None:
    """Register the requests about the name at a position."""

    @server.feature(types.TEXT_DOCUMENT_HOVER)
    def hovered(params: types.HoverParams) -> types.Hover | None:
        view = server.view(params.text_document)
        return None if view is None else hover(view, params.position)

    @server.feature(types.TEXT_DOCUMENT_DEFINITION)
    def defined(params: types.DefinitionParams) -> list[types.Location]:
        view = server.view(params.text_document)
        return [] if view is None else definition(view, params.position)

    @server.feature(types.TEXT_DOCUMENT_REFERENCES)
    def referred(params: types.ReferenceParams) -> list[types.Location]:
        view = server.view(params.text_document)
        if view is None:
            return []
        declaration = params.context.include_declaration
        return references(view, params.position, declaration=declaration)

    @server.feature(types.TEXT_DOCUMENT_DOCUMENT_HIGHLIGHT)
    def highlighted(
        params: types.DocumentHighlightParams,
    ) -> list[types.DocumentHighlight]:
        view = server.view(params.text_document)
        return [] if view is None else highlights(view, params.position)

    @server.feature(
        types.TEXT_DOCUMENT_COMPLETION,
        types.CompletionOptions(trigger_characters=[":", "@", ".", '"', "<", "/"]),
    )
    def completed(params: types.CompletionParams) -> types.CompletionList | None:
        view = server.view(params.text_document)
        return None if view is None else completion(view, params.position)

    @server.feature(types.TEXT_DOCUMENT_PREPARE_RENAME)
    def prepared_rename(
        params: types.PrepareRenameParams,
    ) -> types.PrepareRenamePlaceholder | None:
        view = server.view(params.text_document)
        return None if view is None else prepared(view, params.position)

    @server.feature(
        types.TEXT_DOCUMENT_RENAME, types.RenameOptions(prepare_provider=True)
    )
    async def rename(params: types.RenameParams) -> types.WorkspaceEdit | None:
        view = server.view(params.text_document)
        if view is None:
            return None
        code = types.LSPErrorCodes.RequestFailed.value
        if prepared(view, params.position) is None:
            raise JsonRpcException("there is no name here that can be changed", code)
        try:
            return await server.in_background(
                partial(
                    renamed,
                    *(view, params.position, params.new_name),
                    moves=server.moves_files,
                )
            )
        except (RenameError, ToolError) as error:
            raise JsonRpcException(error.message, code) from None


def _add_outlines(server: Server) -> None:
    """Register the requests about a whole document, or about projects."""

    @server.feature(types.TEXT_DOCUMENT_DOCUMENT_SYMBOL)
    def outlined(params: types.DocumentSymbolParams) -> list[types.DocumentSymbol]:
        view = server.view(params.text_document)
        return [] if view is None else document_symbols(view)

    @server.feature(types.WORKSPACE_SYMBOL)
    def searched(params: types.WorkspaceSymbolParams) -> list[types.WorkspaceSymbol]:
        return workspace_symbols(server.files, params.query)

    @server.feature(types.TEXT_DOCUMENT_SEMANTIC_TOKENS_FULL, LEGEND)
    def tokens(params: types.SemanticTokensParams) -> types.SemanticTokens:
        view = server.view(params.text_document)
        return types.SemanticTokens([]) if view is None else semantic_tokens(view)

    @server.feature(types.TEXT_DOCUMENT_SEMANTIC_TOKENS_RANGE, LEGEND)
    def some_tokens(params: types.SemanticTokensRangeParams) -> types.SemanticTokens:
        view = server.view(params.text_document)
        if view is None:
            return types.SemanticTokens([])
        return semantic_tokens(view, params.range)

    @server.feature(types.TEXT_DOCUMENT_FOLDING_RANGE)
    def folded(params: types.FoldingRangeParams) -> list[types.FoldingRange]:
        view = server.view(params.text_document)
        return [] if view is None else folding(view)

    @server.feature(types.TEXT_DOCUMENT_INLAY_HINT)
    def hinted(params: types.InlayHintParams) -> list[types.InlayHint]:
        view = server.view(params.text_document)
        return [] if view is None else inlay_hints(view, params.range)

    @server.feature(
        types.TEXT_DOCUMENT_CODE_ACTION,
        types.CodeActionOptions(
            code_action_kinds=[
                types.CodeActionKind.QuickFix,
                types.CodeActionKind.SourceFixAll,
            ]
        ),
    )
    def acted(params: types.CodeActionParams) -> list[types.CodeAction]:
        view = server.view(params.text_document)
        if view is None:
            return []
        actions = code_actions(view, params.range, params.context.diagnostics)
        only = params.context.only
        return [a for a in actions if only is None or a.kind in only]

    @server.feature(types.TEXT_DOCUMENT_FORMATTING)
    async def formatted(params: types.DocumentFormattingParams) -> list[types.TextEdit]:
        return await server.formatted(params.text_document, None)

    @server.feature(types.TEXT_DOCUMENT_RANGE_FORMATTING)
    async def range_formatted(
        params: types.DocumentRangeFormattingParams,
    ) -> list[types.TextEdit]:
        return await server.formatted(params.text_document, params.range)
