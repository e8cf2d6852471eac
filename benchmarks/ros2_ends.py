"""Nodes of `ros2.py`: what comes on `/in` goes on `/out`, and a driver that measures it.

    python ros2_ends.py echo hand|rclpy|dds TYPE OCTETS reliable|mixed|late
    python ros2_ends.py drive TYPE COUNT RATE OCTETS reliable|mixed|late

An echo writes its processor time for each line that it reads. A driver is a node of rclpy, with
serialized messages; it writes how many came back, and their latencies in milliseconds.
An echo sends one message on `/once`, transient local, which the driver waits for with the last two
kinds of QoS; with mixed QoS readers are best effort.
"""

from __future__ import annotations

import importlib
import json
import os
import sys
import threading
import time
from typing import Any

DEPTH = 100


def class_of(type_: str) -> Any:
    """Return the class of rclpy."""
    package, _, name = type_.split("/")
    return getattr(importlib.import_module(f"{package}.msg"), name)


def profiles(qos: str) -> tuple[Any, Any, Any]:
    """Return rclpy's profiles of writers, of readers, and of what is sent once."""
    from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

    writes = reads = QoSProfile(depth=DEPTH)
    if qos == "mixed":
        best = ReliabilityPolicy.BEST_EFFORT
        reads = QoSProfile(depth=DEPTH, reliability=best)
    local = DurabilityPolicy.TRANSIENT_LOCAL
    return writes, reads, QoSProfile(depth=1, durability=local)


def fill(message: Any, octets: int) -> Any:
    """Give a message that number of octets, if it has any; return it."""
    if octets:
        message.data = bytes(octets)
    return message


def hand(type_: str, octets: int, qos: str) -> None:
    """Spin a node as it is written by hand."""
    import rclpy

    class_ = class_of(type_)
    rclpy.init()
    node = rclpy.create_node("echo")
    writes, reads, once = profiles(qos)
    publisher = node.create_publisher(class_, "out", writes)
    node.create_publisher(class_, "once", once).publish(fill(class_(), octets))

    def echo(message: Any) -> None:
        message.header.frame_id = "echo"
        publisher.publish(message)

    node.create_subscription(class_, "in", echo, reads)
    threading.Thread(target=rclpy.spin, args=(node,), daemon=True).start()


def rtgen(kind: str, type_: str, octets: int, qos: str) -> None:
    """Connect an InPort and OutPorts."""
    from rtgen.facts.ros_qos import PROFILES, Durability, Reliability
    from rtgen.runtime.ports.data_ports import InPort, OutPort
    from rtgen.runtime.ros2.network import RosNode
    from rtgen.runtime.ros2.ports import Joint, RosPorts
    from rtgen.tools.running.ros2_classes import message_classes

    node = RosNode("echo", "/", int(os.environ["ROS_DOMAIN_ID"]))
    if kind == "dds":
        from rtgen.runtime.ros2.dds import open_dds

        network = open_dds(node)
    else:
        from rtgen.runtime.ros2.rclpy import open_rclpy

        network = open_rclpy(node)
    class_ = message_classes(type_)[type_]
    in_: InPort[Any] = InPort("in", class_, "echo0")
    out: OutPort[Any] = OutPort("out", class_, "echo0")
    once: OutPort[Any] = OutPort("once", class_, "echo0")

    def echo() -> None:
        message = in_.read()
        message.header.frame_id = "echo"
        out.write(message)

    in_.call_on_arrival(echo)
    writes = reads = PROFILES["default"]._replace(depth=DEPTH)
    if qos == "mixed":
        reads = reads._replace(reliability=Reliability.BEST_EFFORT)
    local = writes._replace(depth=1, durability=Durability.TRANSIENT_LOCAL)
    joints = (
        *(Joint(in_, "/in", reads), Joint(out, "/out", writes)),
        Joint(once, "/once", local),
    )
    RosPorts(network, joints)
    once.write(fill(class_(), octets))


def echo(kind: str, type_: str, octets: int, qos: str) -> None:
    """Run a node until the input ends."""
    if kind == "hand":
        hand(type_, octets, qos)
    else:
        rtgen(kind, type_, octets, qos)
    print("ready", flush=True)
    for _ in sys.stdin:
        print(time.process_time(), flush=True)


def drive(type_: str, count: int, rate: float, octets: int, qos: str) -> None:
    """Send messages at a rate [Hz], of about that many octets; write what came back."""
    import rclpy
    from rclpy.serialization import serialize_message

    class_ = class_of(type_)
    rclpy.init()
    node = rclpy.create_node("driver")
    writes, reads, once = profiles(qos)
    whole = serialize_message(fill(class_(), octets))
    sent = [0.0] * count
    latencies: dict[int, float] = {}
    done = threading.Event()

    def came(raw: bytes) -> None:
        number = int.from_bytes(raw[4:8], "little", signed=True)
        if 0 <= number < count:
            latencies[number] = (time.perf_counter() - sent[number]) * 1e3
            if len(latencies) == count:
                done.set()
        else:
            known.set()

    known = threading.Event()
    publisher = node.create_publisher(class_, "in", writes)
    node.create_subscription(class_, "out", came, reads, raw=True)
    sent_once = threading.Event()
    if qos != "reliable":
        node.create_subscription(class_, "once", lambda _: sent_once.set(), once)
    threading.Thread(target=rclpy.spin, args=(node,), daemon=True).start()
    begun = time.perf_counter()
    found = None
    if qos != "reliable":
        came_once = sent_once.wait(10.0)
        found = time.perf_counter() - begun if came_once else float("nan")
    while not known.is_set():
        publisher.publish(whole[:4] + b"\xff\xff\xff\xff" + whole[8:])
        known.wait(0.05)
    if found is None:
        found = time.perf_counter() - begun
    time.sleep(0.3)
    print(json.dumps({"found": found}), flush=True)
    sys.stdin.readline()
    next_ = time.perf_counter()
    for number in range(count):
        octets_ = whole[:4] + number.to_bytes(4, "little") + whole[8:]
        while (left := next_ - time.perf_counter()) > 0:
            time.sleep(left)
        sent[number] = time.perf_counter()
        publisher.publish(octets_)
        next_ += 1 / rate
    done.wait(3.0)
    print(json.dumps({"latencies": sorted(latencies.values())}), flush=True)
    os._exit(0)  # the thread that spins would be in the way of an orderly end


if __name__ == "__main__":
    if sys.argv[1] == "echo":
        kind_, type_, size_, qos_ = sys.argv[2:6]
        echo(kind_, type_, int(size_), qos_)
    else:
        kind_, number_, rate_, size_, qos_ = sys.argv[2:7]
        drive(kind_, int(number_), float(rate_), int(size_), qos_)
