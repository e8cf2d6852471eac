"""CORBA objects of a process: servants called by omniORB, references, and stubs."""

from __future__ import annotations

import logging
import threading
from _thread import interrupt_main
from collections.abc import Callable
from typing import Any, Final, Protocol, TypeVar

import omniORB
from omniORB import CORBA, PortableServer, tcInternal

from rtgen.runtime.cdr import UserException
from rtgen.runtime.corba.code_sets import unsendable
from rtgen.runtime.corba.faults import caught, raised
from rtgen.runtime.corba.operations import Operations
from rtgen.runtime.corba.orb import Orb
from rtgen.runtime.corba.wire_conversions import Convert
from rtgen.runtime.corba.wire_types import Interface, WireTypes
from rtgen.runtime.failures import described, ends_run, log
from rtgen.runtime.marshalling.octets import (
    ObjectReference,
    read_reference,
    write_reference,
)
from rtgen.runtime.requests import await_turn, charge
from rtgen.runtime.services.calls import encoded_arguments
from rtgen.runtime.services.servants import (
    Invoker,
    MarshalError,
    ObjectNotExist,
    Servant,
    ServiceError,
    Stub,
    UnknownException,
)

_REPORTED = (ObjectNotExist, UnknownException)
"""Operations whose failures are not reported: polling for ACTIVE is harmless, skeletons report."""

CONVERSION: Final = 1e-4
"""Time in which omniORB reads a request and writes its answer [s]."""

_S = TypeVar("_S", bound=Servant)


class Remote:
    """Calls the object of a reference."""

    def __init__(self, reference: Any, operations: Operations) -> None:
        self.reference = reference
        self._operations = operations
        self._invoke = reference._obj.invoke

    @property
    def reachable(self) -> bool:
        """See `Carrier`."""
        return True

    def call(self, operation: str, arguments: tuple[object, ...]) -> object:
        """Make a call. Raises what the operation declares, CdrError and ServiceError."""
        try:
            return self.attempt(operation, arguments)
        except CORBA.SystemException as error:
            raise caught(operation, error) from error

    def attempt(self, operation: str, arguments: tuple[object, ...]) -> object:
        """Make a call, without converting system exceptions."""
        found = self._operations.of.get(operation) or self._operations.find(operation)
        given = arguments
        try:
            if found.request is not None:
                given = found.request(arguments)
            result = self._invoke(operation, found.descriptor, given)
        except CORBA.UserException as error:
            raise found.caught(error) from None
        except CORBA.DATA_CONVERSION as error:
            _tell_fault(operation, found, arguments)
            why = unsendable(self.reference, arguments)
            raise MarshalError(f"{operation}: {why}") from error
        except (CORBA.BAD_PARAM, CORBA.MARSHAL) as error:
            if error.completed == CORBA.COMPLETED_NO:
                _tell_fault(operation, found, arguments)
            raise
        except (TypeError, ValueError, AttributeError, ArithmeticError) as error:
            _tell_fault(operation, found, arguments)
            raise MarshalError(f"{operation}: {error}") from error
        return result if found.values is None else found.values(result)


_SIGNATURES = "_rtgen_operations"
"""Additional operation of rtgen's objects: the signatures of the interface."""
_TEXTS = (tcInternal.tv_sequence, (tcInternal.tv_string, 0), 0)
_TELLING = ((), (_TEXTS,), None)


def signatures(reference: Any) -> list[str] | None:
    """Return the signatures of an object's interface; None for an object not served by rtgen.

    Raises omniORB's exception if the object cannot be reached.
    """
    try:
        answer: list[str] = reference._obj.invoke(_SIGNATURES, _TELLING, ())
    except (CORBA.BAD_OPERATION, CORBA.NO_IMPLEMENT):
        return None
    return answer


def _tell_fault(operation: str, found: Any, arguments: tuple[object, ...]) -> None:
    """Raise CdrError or BadOperation with the place, if the codecs reject the arguments, too."""
    plain = tuple(None if isinstance(a, Servant) else a for a in arguments)
    encoded_arguments(operation, found.call, plain)


class Objects:
    """The objects of one process, and its references."""

    def __init__(self, orb: Orb) -> None:
        self._orb = orb.orb
        self._activate = orb.activate
        self.withdraw = orb.deactivate
        """Removes an object created by `serve`."""
        self._busy = orb.busy
        self._limit = orb.limit
        self.types = WireTypes(self)
        self._operations: dict[type[Servant], Operations] = {}
        self._classes: dict[type[Servant], type[Any]] = {}
        self._exported: dict[int, tuple[Servant, Any]] = {}
        self._exporting = threading.Lock()

    def operations(self, interface: type[Servant]) -> Operations:
        """Return the operations of an interface. Raises ServiceError if it is local."""
        found = self._operations.get(interface)
        if found is None:
            found = self._operations[interface] = Operations(interface, self.types)
        return found

    def serve(
        self,
        interface: type[Servant],
        call: Invoker,
        exists: Callable[[], bool] = lambda: True,
    ) -> Any:
        """Create an object that delegates its calls; return a reference.

        Raises ServiceError if the interface is local.
        """
        class_ = self._classes.get(interface)
        if class_ is None:
            class_ = _servant_class(interface, self.operations(interface))
            self._classes[interface] = class_
        return self._activate(class_(call, exists, self._busy))

    def remote(self, interface: type[Servant], reference: Any) -> Remote:
        """Return a caller of the object, using an interface."""
        self._limit(reference)
        return Remote(reference, self.operations(interface))

    def stub(self, interface: type[_S], reference: Any) -> _S:
        """Return a stub that calls the object of a reference."""
        made: _S = interface._stub_(self.remote(interface, reference).call)
        return made

    def exported(self, value: Any, interface: Interface) -> Any:
        """Convert a servant, stub or `ObjectReference` to omniORBpy's reference; None to nil."""
        if value is None:
            return None
        if isinstance(value, Stub):
            remote = getattr(value._invoker, "__self__", None)
            if isinstance(remote, Remote):
                return remote.reference
        if isinstance(value, Servant):
            return self._servant(value)
        if not isinstance(value, ObjectReference):
            raise TypeError(f"{value!r} is not an object")
        octets = bytearray(b"\1\0\0\0")
        write_reference(octets, value, True)
        return self._orb.string_to_object(f"IOR:{octets.hex()}")

    def imported(self, reference: Any, interface: Interface) -> Any:
        """Convert omniORBpy's reference to a stub, or to an `ObjectReference` without interface."""
        if reference is None:
            return None
        if interface is not None:
            return self.stub(interface, reference)
        octets = omniORB.cdrMarshal(CORBA._tc_Object, reference, 1)
        return read_reference(octets, 0, True)[0]

    def _servant(self, servant: Servant) -> Any:
        """Return a reference to a servant passed in a call; it exists as long as the ORB."""
        with self._exporting:
            known = self._exported.get(id(servant))
            if known is None:
                interface = _interface_of(servant)
                skeleton = interface._skeleton_(servant)
                known = servant, self.serve(interface, skeleton.dispatch)
                self._exported[id(servant)] = known
            return known[1]


def _interface_of(servant: Servant) -> type[Servant]:
    return next(c for c in type(servant).__mro__ if "_skeleton_" in vars(c))


class _Described(Protocol):
    """The part of an interface that omniORB needs."""

    @property
    def repository_id(self) -> str: ...

    @property
    def bases(self) -> tuple[Any, ...]: ...


class SkeletonClass:
    """Attribute by which omniORB finds the interfaces of a servant."""

    def __init__(self, descriptor: _Described, operations: Any) -> None:
        self._NP_RepositoryId = descriptor.repository_id
        self._omni_op_d = operations
        # The name by which omniORB looks up the base interfaces.
        self.__bases__ = tuple(SkeletonClass(base, {}) for base in descriptor.bases)


def _servant_class(interface: type[Servant], operations: Operations) -> type[Any]:
    descriptor = interface._descriptor_
    described = {name: o.descriptor for name, o in operations.of.items()}
    described[_SIGNATURES] = _TELLING

    def keep(
        self: Any, call: Invoker, exists: Callable[[], bool], busy: list[None]
    ) -> None:
        self._call = call
        self._exists = exists
        self._busy = busy

    parts: dict[str, Any] = {
        "__init__": keep,
        "_NP_RepositoryId": descriptor.repository_id,
        "_omni_op_d": described,
        "_omni_skeleton": SkeletonClass(descriptor, described),
        "_non_existent": lambda self: not self._exists(),
        _SIGNATURES: lambda self: list(descriptor.operations),
    }
    for name, operation in operations.of.items():
        parts[name] = _method(name, operation)
    return type(interface.__name__, (PortableServer.Servant,), parts)


def begin() -> float | None:
    """Wait for the turn of a call of another process; return as `await_turn` does."""
    if isinstance(threading.current_thread(), omniORB.WorkerThread):
        return await_turn()
    return None  # a thread of this process calls


def _method(name: str, operation: Any) -> Callable[..., Any]:
    count, arguments_of, reply = operation.count, operation.arguments, operation.reply

    def method(self: Any, *values: Any) -> Any:
        given = values[:count]
        begun = begin()
        self._busy.append(None)
        try:
            if arguments_of is not None:
                given = _checked(arguments_of, given, "the request is wrong")
            result = self._call(name, given)
            if reply is None:
                return result
            return _checked(reply, result, "the result is wrong")
        except UserException as error:
            declared = operation.raised(error)
            if declared is not None:
                raise declared from None
            fault = UnknownException(f"{type(error).__name__} is not declared")
            log.warning("%s: %s", name, fault, exc_info=error)
            raise raised(fault) from error
        except ServiceError as error:
            level = logging.DEBUG if isinstance(error, _REPORTED) else logging.WARNING
            log.log(level, "%s: %s", name, error, exc_info=error.__cause__)
            raise raised(error) from None
        except BaseException as error:
            if not ends_run(error):
                raise
            # This is a thread of the ORB; the run ends in the main thread.
            interrupt_main()
            raise raised(UnknownException(f"{name}: {described(error)}")) from error
        finally:
            self._busy.pop()
            charge(begun, CONVERSION)

    return method


def _checked(convert: Convert, value: Any, what: str) -> Any:
    try:
        return convert(value)
    except (ServiceError, CORBA.Exception):
        raise
    except Exception as error:  # any exception that a value of a wrong type causes
        raise MarshalError(f"{what}: {error}") from error
