"""TECS OpaqueRPC, for generated codecs, proxies and unmarshallers."""

from rtgen.runtime.opaque_rpc.channel import (
    Channel,
    ExchangeChannel,
    Handler,
    Handlers,
    More,
)
from rtgen.runtime.opaque_rpc.codecs import (
    REPLY_LIMIT,
    REQUEST_LIMIT,
    Codec,
    Messages,
    ReplyOrder,
)
from rtgen.runtime.opaque_rpc.digest import check_signature, peer_digest
from rtgen.runtime.opaque_rpc.errors import (
    E_BOVR,
    E_CLS,
    E_ID,
    E_MAGIC,
    E_NOEXS,
    E_NOMEM,
    E_OBJ,
    E_OK,
    E_PAR,
    E_RESET,
    E_RPC,
    E_SYS,
    E_TMOUT,
    E_WBLK,
    ERCD,
    MERCD,
    SERCD,
    ArgumentError,
    ChannelError,
    ProtocolError,
    RpcError,
)
from rtgen.runtime.opaque_rpc.interface import OpaqueRpc
from rtgen.runtime.opaque_rpc.link import Link, LinkSettings
from rtgen.runtime.opaque_rpc.messages import (
    Dispatcher,
    MessageReader,
    PacketServer,
    SharedUnmarshaller,
    Unmarshaller,
    serve_message,
)
from rtgen.runtime.opaque_rpc.proxy import CommunicationChannel, ProxyServant
from rtgen.runtime.opaque_rpc.serial import SerialChannel, SerialServer
from rtgen.runtime.opaque_rpc.shared_channel import SharedChannel
from rtgen.runtime.opaque_rpc.simulated import SimulatedChannel, SimulatedServer
from rtgen.runtime.opaque_rpc.tcp_channel import TcpChannel
from rtgen.runtime.opaque_rpc.tcp_server import TcpServer
from rtgen.runtime.opaque_rpc.tdr import BIG, LITTLE, NETWORK, Order, Tdr, make_tdr

__all__ = [
    "BIG",
    "ERCD",
    "E_BOVR",
    "E_CLS",
    "E_ID",
    "E_MAGIC",
    "E_NOEXS",
    "E_NOMEM",
    "E_OBJ",
    "E_OK",
    "E_PAR",
    "E_RESET",
    "E_RPC",
    "E_SYS",
    "E_TMOUT",
    "E_WBLK",
    "LITTLE",
    "MERCD",
    "NETWORK",
    "REPLY_LIMIT",
    "REQUEST_LIMIT",
    "SERCD",
    "ArgumentError",
    "Channel",
    "ChannelError",
    "Codec",
    "CommunicationChannel",
    "Dispatcher",
    "ExchangeChannel",
    "Handler",
    "Handlers",
    "Link",
    "LinkSettings",
    "MessageReader",
    "Messages",
    "More",
    "OpaqueRpc",
    "Order",
    "PacketServer",
    "ProtocolError",
    "ProxyServant",
    "ReplyOrder",
    "RpcError",
    "SerialChannel",
    "SerialServer",
    "SharedChannel",
    "SharedUnmarshaller",
    "SimulatedChannel",
    "SimulatedServer",
    "TcpChannel",
    "TcpServer",
    "Tdr",
    "Unmarshaller",
    "check_signature",
    "make_tdr",
    "peer_digest",
    "serve_message",
]
