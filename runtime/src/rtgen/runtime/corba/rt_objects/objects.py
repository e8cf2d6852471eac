"""Objects with interfaces of RTC and SDO: those of this process, and calls of others."""

from __future__ import annotations

import re
import time
from contextlib import suppress
from functools import cache
from typing import Any, Final

import omniORB
from omniORB import CORBA, PortableServer

from rtgen.runtime.corba import iors
from rtgen.runtime.corba.code_sets import unsendable
from rtgen.runtime.corba.faults import is_timeout
from rtgen.runtime.corba.objects import CONVERSION, SkeletonClass, begin
from rtgen.runtime.corba.orb import Orb
from rtgen.runtime.corba.rt_objects.wire import Interface
from rtgen.runtime.failures import log
from rtgen.runtime.requests import Pace, charge

_SHARE: Final = 0.2
"""The part of the time for reading profiles, configurations and so on."""
_BURST: Final = 0.5
"""Time that is saved up for that, such as for the start of a tool [s]."""
_READING: Final = re.compile(r"get_(?!component_state)").match
"""Operations that wait: not those for states, samples and connections."""
_FIRST: Final = re.compile(
    r"(?:de)?activate|reset|start|stop|exit|finalize|put$|get$|on_"
).match
"""Operations that never wait: people stop a robot by them, or they are samples and ticks."""
_POSTING: Final = 100
"""Milliseconds in which a request is sent."""


class CallError(Exception):
    """A call that cannot be carried out, with the reason."""


class Exported:
    """Creates CORBA objects for Python objects that implement an interface, and calls others.

    `gives_up`: after a call that was not answered in time, others to that process fail at once, for
    as long as it has waited.
    """

    def __init__(self, orb: Orb, *, gives_up: bool = True) -> None:
        self._orb = orb
        self.withdraw, self.hasten = orb.deactivate, orb.hasten
        """Remove an object created by `serve`; bound the calls made from now on."""
        self._gives_up = gives_up
        self._pace = Pace(_SHARE, _BURST)
        self._silent: dict[str, float] = {}
        """Processes that did not answer in time, and until when they are not called again."""

    def serve(self, interface: Interface, target: object) -> Any:
        """Return a reference to an object whose calls are those of `target`."""
        return self._orb.activate(
            _class_of(interface)(target, self._orb.busy, self._pace)
        )

    def local(self, reference: Any) -> Any:
        """Return the Python object of a reference; None for one of another process."""
        poa = self._orb.poa
        if reference is None:
            return None
        try:
            return getattr(poa.reference_to_servant(reference), "_target", None)
        except (PortableServer.POA.WrongAdapter, PortableServer.POA.ObjectNotActive):
            return None

    def call(
        self, reference: Any, interface: Interface, operation: str, *arguments: Any
    ) -> Any:
        """Call an object of another process. Raises omniORB's exceptions and CallError."""
        if self._silent and time.monotonic() < self._silent.get(
            iors.place(self.text(reference)), 0.0
        ):
            raise CORBA.TIMEOUT(0, CORBA.COMPLETED_NO)
        self._orb.limit(reference)
        descriptor = interface.operations[operation]
        try:
            return reference._obj.invoke(operation, descriptor, arguments)
        except CORBA.SystemException as error:
            if self._gives_up and is_timeout(error):
                until = time.monotonic() + self._orb.limit_in_seconds
                self._silent[iors.place(self.text(reference))] = until
            if isinstance(error, CORBA.DATA_CONVERSION):
                why = unsendable(reference, arguments)
                raise CallError(why) from error
            raise

    def post(
        self, reference: Any, interface: Interface, operation: str, *arguments: Any
    ) -> None:
        """Send a request without waiting for its answer, also to a process that does not answer."""
        omniORB.setClientCallTimeout(reference, _POSTING)
        descriptor = interface.operations[operation]
        with suppress(CORBA.SystemException):
            reference._obj.invoke(operation, descriptor, arguments)

    def text(self, reference: Any) -> str:
        """Return the IOR of a reference."""
        ior: str = self._orb.orb.object_to_string(reference)
        return ior

    def key(self, reference: Any) -> bytes:
        """Return the object key of a reference, which equivalent references share; empty without.

        For `_hash`, omniORBpy acquires omniORB's lock while it holds that of the interpreter. A
        thread that looks up or activates a servant acquires them in the reverse order, so both
        threads would wait for each other forever.
        """
        return iors.key(self.text(reference))

    def reference(self, text: str) -> Any:
        """Return the reference of an IOR or corbaloc; None if there is none."""
        if not text.startswith(("IOR:", "corbaloc:", "corbaname:")):
            return None
        try:
            return self._orb.orb.string_to_object(text)
        except CORBA.SystemException:
            return None


@cache
def _class_of(interface: Interface) -> type[Any]:
    operations = interface.operations

    def keep(self: Any, target: object, busy: list[None], pace: Pace) -> None:
        self._target = target
        self._busy = busy
        self._pace = pace

    parts: dict[str, Any] = {
        "__init__": keep,
        "_NP_RepositoryId": interface.repository_id,
        "_omni_op_d": operations,
        "_omni_skeleton": SkeletonClass(interface, operations),
    }
    for name in operations:
        method = _method(name)
        if _READING(name):
            method = _paced(method)
        elif not _FIRST(name):
            method = _called(method)
        parts[name] = method
    return type(f"{interface.repository_id}", (PortableServer.Servant,), parts)


def _method(name: str) -> Any:
    def method(self: Any, *arguments: Any) -> Any:
        self._busy.append(None)
        try:
            return getattr(self._target, name)(*arguments)
        except CORBA.Exception:
            raise
        except Exception as error:
            log.warning("%s failed", name, exc_info=error)
            raise CORBA.UNKNOWN(0, CORBA.COMPLETED_MAYBE) from error
        finally:
            self._busy.pop()

    return method


def _paced(method: Any) -> Any:
    """Return a method whose calls together take a part of the time."""

    def paced(self: Any, *arguments: Any) -> Any:
        self._pace.wait()
        begun = time.thread_time()
        try:
            return method(self, *arguments)
        finally:
            self._pace.charge(time.thread_time() - begun + CONVERSION)

    return paced


def _called(method: Any) -> Any:
    """Return a method that waits for its turn while components leave out ticks."""

    def called(self: Any, *arguments: Any) -> Any:
        begun = begin()
        try:
            return method(self, *arguments)
        finally:
            charge(begun, CONVERSION)

    return called
