"""A program of cyclonedds alone that uses DDS-RPC's basic mapping, with hand-written types.

Arguments: domain, partition, configuration of Cyclone DDS, `call` or `serve`: a client or the
server of `OpaqueRpc` at `a/given/rpc`. A client prints its results as JSON.
"""

import hashlib
import json
import sys
import time
from dataclasses import dataclass

from cyclonedds.core import Policy, Qos
from cyclonedds.domain import Domain, DomainParticipant
from cyclonedds.idl import IdlEnum, IdlStruct, IdlUnion, annotations, types
from cyclonedds.pub import DataWriter, Publisher
from cyclonedds.sub import DataReader, Subscriber
from cyclonedds.topic import Topic


def hash_of(name: str) -> int:
    octets = hashlib.md5(name.encode()).digest()
    return int.from_bytes(octets[:4], "little", signed=True)


BEGIN, MORE, END, RESET = map(hash_of, ("begin", "more", "end", "reset"))
FAILED = hash_of("OpaqueRpc::Failed")


@dataclass
@annotations.final
class EntityId(IdlStruct, typename="dds::EntityId_t"):
    entityKey: types.array[types.byte, 3]
    entityKind: types.byte


@dataclass
@annotations.final
class Guid(IdlStruct, typename="dds::GUID_t"):
    guidPrefix: types.array[types.byte, 12]
    entityId: EntityId


@dataclass
@annotations.final
class SequenceNumber(IdlStruct, typename="dds::SequenceNumber_t"):
    high: types.int32
    low: types.uint32


@dataclass
@annotations.final
class SampleIdentity(IdlStruct, typename="dds::SampleIdentity"):
    writer_guid: Guid
    sequence_number: SequenceNumber


class RemoteException(IdlEnum, typename="dds::rpc::RemoteExceptionCode_t"):
    REMOTE_EX_OK = 0
    REMOTE_EX_UNSUPPORTED = 1
    REMOTE_EX_INVALID_ARGUMENT = 2
    REMOTE_EX_OUT_OF_RESOURCES = 3
    REMOTE_EX_UNKNOWN_OPERATION = 4
    REMOTE_EX_UNKNOWN_EXCEPTION = 5


@dataclass
@annotations.final
class RequestHeader(IdlStruct, typename="dds::rpc::RequestHeader"):
    requestId: SampleIdentity
    instanceName: types.bounded_str[255]


@dataclass
@annotations.final
class ReplyHeader(IdlStruct, typename="dds::rpc::ReplyHeader"):
    relatedRequestId: SampleIdentity
    remoteEx: RemoteException


@dataclass
@annotations.final
class BeginIn(IdlStruct, typename="OpaqueRpc_begin_In"):
    request: types.sequence[types.byte]
    first: types.uint32


@dataclass
@annotations.final
class MoreIn(IdlStruct, typename="OpaqueRpc_more_In"):
    count: types.uint32


@dataclass
@annotations.final
class EndIn(IdlStruct, typename="OpaqueRpc_end_In"):
    dummy: types.byte


@dataclass
@annotations.final
class ResetIn(IdlStruct, typename="OpaqueRpc_reset_In"):
    dummy: types.byte


@annotations.final
class Call(IdlUnion, discriminator=types.int32, typename="OpaqueRpc_Call"):
    begin: types.case[BEGIN, BeginIn]
    more: types.case[MORE, MoreIn]
    end: types.case[END, EndIn]
    reset: types.case[RESET, ResetIn]
    unknownOp: types.default[types.byte]


@dataclass
@annotations.final
class Request(IdlStruct, typename="OpaqueRpc_Request"):
    header: RequestHeader
    data: Call


@dataclass
@annotations.final
class BeginOut(IdlStruct, typename="OpaqueRpc_begin_Out"):
    return_: types.sequence[types.byte]


@dataclass
@annotations.final
class MoreOut(IdlStruct, typename="OpaqueRpc_more_Out"):
    return_: types.sequence[types.byte]


@dataclass
@annotations.final
class EndOut(IdlStruct, typename="OpaqueRpc_end_Out"):
    dummy: types.byte


@dataclass
@annotations.final
class ResetOut(IdlStruct, typename="OpaqueRpc_reset_Out"):
    dummy: types.byte


@dataclass
@annotations.final
class Failed(IdlStruct, typename="OpaqueRpc::Failed"):
    code: types.int32
    reason: str


@annotations.final
class BeginResult(
    IdlUnion, discriminator=types.int32, typename="OpaqueRpc_begin_Result"
):
    result: types.case[0, BeginOut]
    failed_ex: types.case[FAILED, Failed]
    unknownEx: types.default[types.byte]


@annotations.final
class MoreResult(IdlUnion, discriminator=types.int32, typename="OpaqueRpc_more_Result"):
    result: types.case[0, MoreOut]
    failed_ex: types.case[FAILED, Failed]
    unknownEx: types.default[types.byte]


@annotations.final
class EndResult(IdlUnion, discriminator=types.int32, typename="OpaqueRpc_end_Result"):
    result: types.case[0, EndOut]
    unknownEx: types.default[types.byte]


@annotations.final
class ResetResult(
    IdlUnion, discriminator=types.int32, typename="OpaqueRpc_reset_Result"
):
    result: types.case[0, ResetOut]
    unknownEx: types.default[types.byte]


@annotations.final
class Return(IdlUnion, discriminator=types.int32, typename="OpaqueRpc_Return"):
    begin: types.case[BEGIN, BeginResult]
    more: types.case[MORE, MoreResult]
    end: types.case[END, EndResult]
    reset: types.case[RESET, ResetResult]
    unknownOp: types.default[types.byte]


@dataclass
@annotations.final
class Reply(IdlStruct, typename="OpaqueRpc_Reply"):
    header: ReplyHeader
    data: Return


class Program:
    """A reader and a writer of the service."""

    def __init__(self, number: int, partition: str, serves: bool) -> None:
        participant = DomainParticipant(number)
        scope = Qos(Policy.Partition([partition]))
        publisher, subscriber = Publisher(participant, scope), Subscriber(
            participant, scope
        )
        qos = Qos(Policy.Reliability.Reliable(10**9), Policy.History.KeepLast(64))
        durable = Qos(Policy.Durability.TransientLocal, base=qos)
        requests = Topic(participant, "a/given/rpcRequest", Request)
        replies = Topic(participant, "a/given/rpcReply", Reply)
        if serves:
            self.writer = DataWriter(publisher, replies, durable)
            self.reader = DataReader(subscriber, requests, qos)
        else:
            self.writer = DataWriter(publisher, requests, qos)
            self.reader = DataReader(subscriber, replies, qos)

    def take(self):
        return [sample for sample in self.reader.take(10) if hasattr(sample, "data")]


def call(program: Program) -> None:
    deadline = time.monotonic() + 60
    while not (
        program.writer.get_matched_subscriptions()
        and program.reader.get_matched_publications()
    ):
        assert time.monotonic() < deadline, "no server was found"
        time.sleep(0.01)
    guid = Guid(list(b"independent!"), EntityId([1, 2, 3], 4))
    got: list[list[object]] = []
    for number, (octets, first) in enumerate([(b"ab", 2), (b"", 7), (b"defect", 1)]):
        identity = SampleIdentity(guid, SequenceNumber(0, number))
        data = Call(begin=BeginIn(list(octets), first))
        program.writer.write(Request(RequestHeader(identity, ""), data))
        while not (replies := program.take()):
            assert time.monotonic() < deadline, "no reply came"
            time.sleep(0.005)
        [reply] = replies
        answered = reply.header.relatedRequestId
        assert bytes(answered.writer_guid.guidPrefix) == b"independent!"
        assert answered.sequence_number.low == number
        code = reply.header.remoteEx.value
        if code:
            got.append([code])
            continue
        result = reply.data.begin
        if result.discriminator == 0:
            got.append([code, 0, bytes(result.result.return_).decode()])
        else:
            failed = result.failed_ex
            got.append([code, 0, failed.code, failed.reason])
    print(json.dumps(got))


def serve(program: Program) -> None:
    print("ready", flush=True)
    while True:
        for request in program.take():
            code = RemoteException.REMOTE_EX_OK
            if request.data.discriminator == BEGIN:
                given = request.data.begin
                octets = bytes(given.request)
                if octets:
                    text = octets[::-1] + str(given.first).encode()
                    result = BeginResult(result=BeginOut(list(text)))
                else:
                    result = BeginResult(failed_ex=Failed(given.first, "empty"))
                data = Return(begin=result)
            elif request.data.discriminator == END:
                data = Return(end=EndResult(result=EndOut(0)))
            else:
                code = RemoteException.REMOTE_EX_UNKNOWN_OPERATION
                data = Return(discriminator=0, value=0)
            header = ReplyHeader(request.header.requestId, code)
            program.writer.write(Reply(header, data))
        time.sleep(0.002)


def main(number: int, partition: str, config: str, role: str) -> None:
    domain = Domain(number, config)
    (serve if role == "serve" else call)(Program(number, partition, role == "serve"))
    del domain


main(int(sys.argv[1]), *sys.argv[2:])
