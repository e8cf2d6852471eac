"""The digest of a signature over the wire: request, answer, comparison."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from boards import emit, imported, joined, write

from rtgen.runtime.opaque_rpc import (
    BIG,
    LITTLE,
    NETWORK,
    ChannelError,
    Codec,
    Dispatcher,
    ExchangeChannel,
    PacketServer,
    ProtocolError,
    TcpChannel,
    TcpServer,
    check_signature,
    peer_digest,
)
from rtgen.runtime.opaque_rpc.digest import DIGEST

SIGNATURE = "signature sLine { ER move( [in] int32_t x, [in] int32_t y ); };"
SWAPPED = "signature sLine { ER move( [in] int32_t y, [in] int32_t x ); };"


class Line:
    """A target."""

    def move(self, x: int, y: int) -> int:
        return x + y


def _codec(folder: Path, text: str) -> Iterator[type[Codec]]:
    folder.mkdir()
    emission, _ = emit(folder, {"line.cdl": joined(text, "sLine")})
    write(folder, emission.artifacts)
    with imported(folder, "robots.tecs.line.line_codec") as (module,):
        yield module.LineCodec


@pytest.fixture(name="codec", scope="module")
def codec_fixture(tmp_path_factory: pytest.TempPathFactory) -> Iterator[type[Codec]]:
    """Return the codec of the signature."""
    yield from _codec(tmp_path_factory.mktemp("line") / "made", SIGNATURE)


@pytest.fixture(name="swapped", scope="module")
def swapped_fixture(tmp_path_factory: pytest.TempPathFactory) -> Iterator[type[Codec]]:
    """Return the codec of the signature with its parameters swapped."""
    yield from _codec(tmp_path_factory.mktemp("line") / "made", SWAPPED)


@pytest.mark.parametrize("tdr", [NETWORK, LITTLE, BIG])
def test_a_peer_of_the_same_signature_answers_with_its_digest(
    codec: type[Codec], tdr: Any
) -> None:
    made = codec(tdr)
    channel = ExchangeChannel(PacketServer(Dispatcher(Line(), made)))
    assert peer_digest(channel, made) == made.digest
    check_signature(channel, made)


def test_the_bytes_of_question_and_answer(codec: type[Codec]) -> None:
    made = codec()
    server = PacketServer(Dispatcher(Line(), made))
    reply = server(bytes.fromhex("672a 7fff 5a3c"))
    assert reply.hex() == f"561e{made.digest}6d5e"


def test_swapped_parameters_are_found_and_calls_go_on(
    codec: type[Codec], swapped: type[Codec]
) -> None:
    with TcpServer(Dispatcher(Line(), codec()), port=0) as server:
        channel = TcpChannel(*server.address)
        with pytest.raises(ProtocolError, match="made from another signature"):
            check_signature(channel, swapped())
        made: Any = codec()
        check_signature(channel, made)
        assert made.move.call(channel, 2, 3) == 5
        channel.close()


def test_a_peer_that_does_not_know_the_question_closes_the_connection(
    codec: type[Codec],
) -> None:
    dispatcher = Dispatcher(Line(), codec())
    del dispatcher.handlers[codec().request_head(DIGEST)]  # type: ignore[attr-defined]
    with TcpServer(dispatcher, port=0) as server:
        channel = TcpChannel(*server.address)
        made: Any = codec()
        with pytest.raises(ChannelError):
            peer_digest(channel, made)
        assert made.move.call(channel, 2, 3) == 5
        channel.close()


def test_an_answer_without_the_marks_is_refused(codec: type[Codec]) -> None:
    channel = ExchangeChannel(lambda _: bytes(12))
    with pytest.raises(ProtocolError, match="no answer with a digest"):
        peer_digest(channel, codec())


def test_a_question_with_a_wrong_end_is_refused(codec: type[Codec]) -> None:
    server = PacketServer(Dispatcher(Line(), codec()))
    with pytest.raises(ChannelError):
        server(bytes.fromhex("672a 7fff 5a3d"))
