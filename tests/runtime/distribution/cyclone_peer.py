"""A program of cyclonedds alone, with hand-written types: reads an OutPort, writes to an InPort.

Arguments: domain, partition, configuration of Cyclone DDS. It writes 0.5, 1.5 ... to `a/in/in`, and
prints as JSON the first five numbers that it reads from `a/out/out`.
"""

import json
import sys
import time
from dataclasses import dataclass

from cyclonedds.core import Policy, Qos
from cyclonedds.domain import Domain, DomainParticipant
from cyclonedds.idl import IdlStruct, annotations, types
from cyclonedds.pub import DataWriter, Publisher
from cyclonedds.sub import DataReader, Subscriber
from cyclonedds.topic import Topic


@dataclass
@annotations.final
class Time(IdlStruct, typename="RTC::Time"):
    sec: types.uint32
    nsec: types.uint32


@dataclass
@annotations.final
class TimedDouble(IdlStruct, typename="RTC::TimedDouble"):
    tm: Time
    data: types.float64


def main(number: int, partition: str, config: str) -> None:
    domain = Domain(number, config)
    participant = DomainParticipant(number)
    scope = Qos(Policy.Partition([partition]))
    reliable = Qos(Policy.Reliability.Reliable(10**9), Policy.History.KeepLast(100))
    out = Topic(participant, "a/out/out", TimedDouble)
    inward = Topic(participant, "a/in/in", TimedDouble)
    reader = DataReader(Subscriber(participant, scope), out, reliable)
    writer = DataWriter(Publisher(participant, scope), inward)
    got: list[float] = []
    sent = 0
    deadline = time.monotonic() + 60
    while len(got) < 5 and time.monotonic() < deadline:
        got += [sample.data for sample in reader.take(100)]
        if writer.get_matched_subscriptions():
            writer.write(TimedDouble(Time(1, 2), sent + 0.5))
            sent += 1
        time.sleep(0.01)
    print(json.dumps(got[:5]))
    del reader, writer, participant, domain


main(int(sys.argv[1]), *sys.argv[2:])
