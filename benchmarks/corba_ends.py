"""Samples over CORBA for the benchmark `transports.py`: by rtgen, and by omniORBpy's stubs alone.

A topic is the object of its only reader, found by a naming service; a write is a call of
`InPortCdr::put`, as `rtgen.runtime.corba` makes it for connections with the interface type
`corba_cdr`, with encoding.
"""

from __future__ import annotations

import importlib
import os
import sys
import sysconfig
from collections.abc import Callable
from typing import Any

import omniORB

from rtgen.runtime.corba.naming import Naming
from rtgen.runtime.corba.orb import Orb
from rtgen.runtime.corba.rt_objects.objects import Exported
from rtgen.runtime.corba.rt_objects.wire import IN_PORT_CDR
from rtgen.runtime.distribution.medium import Qos, Sample, Topic
from rtgen.runtime.return_codes import PORT_OK, PortStatus

_KIND = "topic"
_IDL = """
module Bare {
  struct Time { unsigned long sec; unsigned long nsec; };
  struct Point2D { double x; double y; };
  struct Pose2D { Point2D position; double heading; };
  struct TimedPose2D { Time tm; Pose2D data; };
  struct TimedLong { Time tm; long data; };
  struct TimedOctetSeq { Time tm; sequence<octet> data; };
  interface Sink {
    void TimedLong(in Bare::TimedLong value);
    void TimedPose2D(in Bare::TimedPose2D value);
    void TimedOctetSeq(in Bare::TimedOctetSeq value);
  };
};
"""
TIMEOUT = 60.0


class CorbaEnds:
    """Publishers and subscriptions of one process: the used part of a `Medium`."""

    def __init__(self, name_server: str) -> None:
        self._orb = Orb(timeout=TIMEOUT)
        self._exported = Exported(self._orb)
        self._naming = Naming(self._orb.orb, name_server)

    def publisher(self, topic: Topic, qos: Qos) -> CorbaPublisher:
        """Return a publisher that calls the reader of a topic."""
        return CorbaPublisher(self._exported, lambda: self._found(topic.name))

    def subscribe(
        self, topic: Topic, qos: Qos, on_sample: Callable[[Sample], None]
    ) -> Any:
        """Register the reader of a topic."""
        reference = self._exported.serve(IN_PORT_CDR, _Reader(on_sample))
        self._bind(topic.name, reference)
        return _Closing(lambda: self._exported.withdraw(reference))

    def bare_reader(self, name: str, taken: Callable[[Any], None]) -> Any:
        """Return a servant of omniidl's skeleton."""
        skeletons = _stubs("Bare__POA")

        class Sink(skeletons.Sink):  # type: ignore[name-defined, misc]
            def take(self, value: Any) -> None:
                taken(value)

            TimedLong = TimedPose2D = TimedOctetSeq = take

        servant = Sink()
        poa = self._orb.poa
        self._bind(name, poa.id_to_reference(poa.activate_object(servant)))
        return servant

    def bare_writer(
        self, name: str, type_: type[Any]
    ) -> tuple[Callable[[Any], Any], Any]:
        """Return a converter from rtgen's values to omniidl's, and the operation of its stub."""
        classes = _stubs("Bare")
        reference = self._found(name)
        assert reference is not None
        sink = reference._narrow(classes.Sink)
        omniORB.setClientCallTimeout(sink, round(TIMEOUT * 1000))
        return lambda value: _made(classes, value), getattr(sink, type_.__name__)

    def close(self) -> None:
        """End the ORB."""
        self._orb.close()

    def _found(self, name: str) -> Any:
        return self._naming.at([(name, _KIND)])

    def _bind(self, name: str, reference: Any) -> None:
        self._naming.bind_object((name, _KIND), reference)


class CorbaPublisher:
    """See `medium.Publisher`."""

    def __init__(self, exported: Exported, find: Callable[[], Any]) -> None:
        self._call = exported.call
        self._find = find
        self._reference: Any = None

    @property
    def matched(self) -> bool:
        """Whether there is a reader."""
        self._reference = self._reference or self._find()
        return self._reference is not None

    def publish(self, octets: bytes) -> None:
        """Call the reader, which was looked up before."""
        if self._reference is None:
            self._reference = self._find()
        self._call(self._reference, IN_PORT_CDR, "put", octets)

    def close(self) -> None:
        """Do nothing: nothing is open."""


class _Reader:
    def __init__(self, on_sample: Callable[[Sample], None]) -> None:
        self._on_sample = on_sample

    def put(self, octets: bytes) -> PortStatus:
        self._on_sample(Sample(octets, None))
        return PORT_OK


class _Closing:
    def __init__(self, close: Callable[[], None]) -> None:
        self.close = close


def _stubs(name: str) -> Any:
    """Return a module that omniidl generated."""
    if "Bare" not in sys.modules:
        scripts = sysconfig.get_path("scripts")
        os.environ["PATH"] = f"{scripts}{os.pathsep}{os.environ['PATH']}"
        omniORB.importIDLString(_IDL)
    return importlib.import_module(name)


def _made(classes: Any, value: Any) -> Any:
    tm = classes.Time(value.tm.sec, value.tm.nsec)
    if type(value).__name__ in ("TimedLong", "TimedOctetSeq"):
        return getattr(classes, type(value).__name__)(tm, value.data)
    place = value.data.position
    pose = classes.Pose2D(classes.Point2D(place.x, place.y), value.data.heading)
    return classes.TimedPose2D(tm, pose)
