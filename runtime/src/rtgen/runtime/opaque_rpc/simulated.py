"""OpaqueRPC in simulated time: calls between components of one system, over its network."""

from __future__ import annotations

from rtgen.runtime.opaque_rpc.errors import E_BOVR, E_OBJ, E_TMOUT, ChannelError
from rtgen.runtime.opaque_rpc.messages import MessageReader, Service, serve
from rtgen.runtime.timing.simulated_network import SimulatedNetwork, Stream

_BLOCK = 65536


class SimulatedChannel:
    """A caller's connection to a server that listens in the same system. See `Channel`.

    It never waits: data that have not arrived when the request was delivered never arrive
    (E_TMOUT), and a refused connection is not retried before the next call (E_OBJ).
    """

    def __init__(self, network: SimulatedNetwork, address: str) -> None:
        self.address = address
        self._network = network
        self._stream: Stream | None = None
        self._busy = False

    def __str__(self) -> str:
        return self.address

    def begin(self, request: bytes, first: int) -> bytes:
        """See `Channel`."""
        if self._busy:
            raise ChannelError(E_TMOUT, f"{self}: in use by another call")
        self._busy = True
        try:
            if self._stream is not None and self._stream.stale:
                self._drop()
            if self._stream is None:
                self._stream = self._connect()
            self.write(request)
            return self.more(first)
        except BaseException:
            self.reset()
            raise

    def more(self, n: int) -> bytes:
        """See `Channel`."""
        try:
            return self._open().receive(n)
        except TimeoutError:
            raise ChannelError(E_TMOUT, f"{self}: no answer") from None
        except EOFError:
            reason = f"{self}: the server closed the connection"
            raise ChannelError(E_BOVR, reason) from None

    def write(self, data: bytes) -> None:
        """Write data of the current call that follow its reply. Raises ChannelError."""
        try:
            self._open().send(data)
        except OSError as error:
            raise ChannelError(E_OBJ, f"{self}: {error.strerror}") from error

    def end(self) -> None:
        """See `Channel`."""
        self._busy = False

    def reset(self) -> None:
        """See `Channel`: closes the connection."""
        self._drop()
        self._busy = False

    def close(self) -> None:
        """Close the connection; a later call reconnects."""
        self.reset()

    def _connect(self) -> Stream:
        try:
            return self._network.connect(self.address)
        except OSError as error:
            raise ChannelError(E_OBJ, str(error)) from error

    def _open(self) -> Stream:
        if self._stream is None:
            raise ChannelError(E_OBJ, f"{self}: no call is under way")
        return self._stream

    def _drop(self) -> None:
        stream, self._stream = self._stream, None
        if stream is not None:
            stream.close()


class _StreamReader(MessageReader):
    """Reads the requests that have arrived."""

    def __init__(self, stream: Stream, limit: int | None) -> None:
        super().__init__(limit)
        self._stream = stream
        self.ended = False

    def _wait(self) -> bytes:
        try:
            data = self._stream.take(_BLOCK)
        except TimeoutError:
            return b""
        self.ended = not data
        return data

    def _receive(self, size: int) -> bytes:
        try:
            return self._stream.take(max(size, _BLOCK))
        except TimeoutError:
            raise ChannelError(E_TMOUT, "the rest of a request is missing") from None

    def send(self, reply: bytes) -> None:
        """Send a reply. Raises ChannelError."""
        try:
            self._stream.send(reply)
        except OSError as error:
            raise ChannelError(E_OBJ, "the connection is closed") from error


class SimulatedServer:
    """Serves components of the same system, one connection at a time, inside their calls.

    An error closes the connection without a reply. Raises OSError if the address is in use.
    """

    def __init__(
        self,
        network: SimulatedNetwork,
        address: str,
        service: Service,
        allocator_size: int | None = None,
    ) -> None:
        self.allocator_size = allocator_size
        self._service = service
        self._stream: Stream | None = None
        self._listener = network.listen(address, self._accept)

    def close(self) -> None:
        """Close the connection and stop listening."""
        self._listener.close()
        self._end()

    def _accept(self, stream: Stream) -> bool:
        if self._stream is not None:
            return False
        reader = _StreamReader(stream, self.allocator_size)

        def answer() -> None:
            # A target may close the server during a call.
            fit = serve(self._service, reader, reader.send, "the simulated network")
            if self._stream is stream and (reader.ended or not fit):
                self._end()

        self._stream = stream
        stream.on_data = answer
        return True

    def _end(self) -> None:
        stream, self._stream = self._stream, None
        if stream is not None:
            stream.close()
