"""JSON-RPC as the Language Server Protocol uses it: order, validity and answers of messages."""

from __future__ import annotations

from typing import Any

import msgspec
from lsprotocol import types
from pygls.exceptions import (
    JsonRpcException,
    JsonRpcInternalError,
    JsonRpcInvalidParams,
    JsonRpcInvalidRequest,
    JsonRpcParseError,
    JsonRpcServerNotInitialized,
)
from pygls.protocol import LanguageServerProtocol, lsp_method

_PARTS = frozenset(("method", "result", "error"))
_SHOWN = 200


class Protocol(LanguageServerProtocol):
    """The protocol without pygls's own copies of texts, which use other line ends.

    Messages are encoded by msgspec, in a tenth of the time.
    """

    def _send_data(self, data: Any) -> None:
        if data and self.writer is not None:
            self._write(self._serialize_message(data))

    def _write(self, message: Any) -> None:
        body = msgspec.json.encode(message, enc_hook=self._serialize_message)
        # On pipes, the writer has finished when it returns.
        assert self.writer is not None
        self.writer.write(b"Content-Length: %d\r\n\r\n" % len(body) + body)

    def structure_message(self, data: dict[str, Any]) -> Any:
        """Return an object of a message unchanged: each object in a message is passed."""
        return data

    def handle_message(self, message: Any) -> None:
        """Handle a parsed message; an invalid request is answered with an error."""
        try:
            structured = self._structured(message)
        except JsonRpcException as error:
            self._server.report_server_error(error, JsonRpcException)
            if not isinstance(message, dict):
                self.refuse(None, error)
            elif {"id", "method"} <= message.keys() or not message.keys() & _PARTS:
                self.refuse(message.get("id"), error)
            return
        if structured is not None:
            super().handle_message(structured)

    def refuse(self, number: Any, error: Exception) -> None:
        """Answer a request of this id, or a message that is none, with an error."""
        if not isinstance(error, JsonRpcException):
            text = f"{type(error).__name__}: {error}"
            error = JsonRpcParseError(text[:_SHOWN])
        number = number if _is_number(number) else None
        answer = {"code": error.code, "message": error.message}
        self._write({"jsonrpc": self.VERSION, "id": number, "error": answer})

    def _structured(self, message: Any) -> Any:
        """Return a message as its type; None for one that is ignored. Raises JsonRpcException."""
        if not isinstance(message, dict):
            raise JsonRpcInvalidRequest(str(message)[:_SHOWN])
        number, method = message.get("id"), message.get("method")
        if message.get("jsonrpc") != self.VERSION:
            raise JsonRpcInvalidRequest('"jsonrpc" is not "2.0"')
        if number is not None and not _is_number(number):
            raise JsonRpcInvalidRequest('"id" is neither a string nor a number')
        if not message.keys() & _PARTS:
            raise JsonRpcInvalidRequest("neither a request nor a response")
        if "method" in message:
            if not isinstance(method, str):
                raise JsonRpcInvalidRequest('"method" is not a string')
            if not self._is_expected(method, is_request="id" in message):
                return None
            if self.get_message_type(method) is None:
                message.setdefault("params", None)
        try:
            structured = super().structure_message(message)
        except JsonRpcInternalError:  # of pygls, for values of wrong kinds
            raise JsonRpcInvalidParams from None
        if method == types.CANCEL_REQUEST and not _is_number(structured.params.id):
            raise JsonRpcInvalidParams
        if "id" in message and not hasattr(structured, "id"):
            raise JsonRpcInvalidRequest(f"{method} is a notification")
        return structured

    def _is_expected(self, method: str, *, is_request: bool) -> bool:
        """Return whether a message may come now. Raises JsonRpcException for a request."""
        error: JsonRpcException | None = None
        if self._shutdown and method != types.EXIT:
            error = JsonRpcInvalidRequest("the server is shut down")
        elif self._workspace is None and method not in (types.INITIALIZE, types.EXIT):
            error = JsonRpcServerNotInitialized()
        elif self._workspace is not None and method == types.INITIALIZE:
            error = JsonRpcInvalidRequest("the server is initialized")
        if error is not None and is_request:
            raise error
        return error is None

    @lsp_method(types.TEXT_DOCUMENT_DID_OPEN)
    def lsp_text_document__did_open(
        self, params: types.DidOpenTextDocumentParams
    ) -> Any:
        yield self.fm.features[types.TEXT_DOCUMENT_DID_OPEN], (params,), None

    @lsp_method(types.TEXT_DOCUMENT_DID_CHANGE)
    def lsp_text_document__did_change(
        self, params: types.DidChangeTextDocumentParams
    ) -> Any:
        yield self.fm.features[types.TEXT_DOCUMENT_DID_CHANGE], (params,), None

    @lsp_method(types.TEXT_DOCUMENT_DID_CLOSE)
    def lsp_text_document__did_close(
        self, params: types.DidCloseTextDocumentParams
    ) -> Any:
        yield self.fm.features[types.TEXT_DOCUMENT_DID_CLOSE], (params,), None


def _is_number(value: Any) -> bool:
    """Return whether a value can be the id of a request."""
    return isinstance(value, int | str)
