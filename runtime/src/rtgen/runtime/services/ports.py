"""Service ports: providers and consumers of interfaces, and the calls between them.

Arguments and results are copied, so components do not share objects. In real time a call runs in
the caller's thread, concurrently with the provider's ticks.
"""

from __future__ import annotations

from array import array
from typing import TYPE_CHECKING, Any, Generic, Protocol, TypeVar

from rtgen.facts.value_checks import CheckValues, count_of
from rtgen.runtime.cdr import UserException
from rtgen.runtime.marshalling.numeric import copied
from rtgen.runtime.services.servants import ObjectNotExist, Servant, Skeleton
from rtgen.runtime.timing.stepping_aside import step_aside

if TYPE_CHECKING:
    from rtgen.runtime.services.checking import CallChecks

S = TypeVar("S", bound=Servant)


class PortOwner(Protocol):
    """The attributes of a component that service ports use."""

    instance_name: str
    providers: dict[tuple[str, str], Provider[Any]]
    consumers: dict[tuple[str, str], Consumer[Any]]

    @property
    def is_active(self) -> bool: ...

    def is_alive(self) -> bool: ...

    def _servant_failed(self, operation: str, error: BaseException) -> None: ...


class Carrier(Protocol):
    """Target of a consumer's calls: a provider, or a transport to one in another process."""

    @property
    def reachable(self) -> bool:
        """Whether the object exists, ACTIVE or not."""

    def call(self, operation: str, arguments: tuple[object, ...]) -> object:
        """Make a call. Raises what the IDL declares, or a ServiceError."""


class Provider(Generic[S]):
    """An interface provided by a component; one servant serves all consumers.

    `limit` is the maximum number of connected consumers, None for any number. Calls are served
    while the component is ACTIVE; with `in_every_state` also in INACTIVE and ERROR.
    """

    __slots__ = (
        "_check",
        "_checks",
        "_component",
        "_skeleton",
        "_type_name",
        "_unchecked",
        "connections",
        "in_every_state",
        "instance",
        "interface",
        "limit",
        "port",
    )

    def __init__(
        self,
        port: str,
        instance: str,
        interface: type[S],
        owner: PortOwner,
        type_name: str = "",
    ) -> None:
        self.port = port
        self.instance = instance
        self._type_name = type_name
        self.interface = interface
        self.limit: int | None = None
        self.connections = 0
        self.in_every_state = False
        self._component = owner
        self._skeleton: Skeleton | None = None
        self._check = CheckValues.NEVER
        self._checks: CallChecks | None = None
        self._unchecked: dict[str, float] = {}
        """Number of calls of each operation that have to be checked."""

    def __str__(self) -> str:
        return f"{self._component.instance_name}.{self.port}:{self.instance}"

    def set_servant(self, servant: S) -> None:
        """Set the servant, usually in `on_initialize`."""
        skeleton = self.interface._skeleton_(servant)
        skeleton._report = self._servant_failed
        self._skeleton = skeleton

    @property
    def servant(self) -> S | None:
        """The servant; None before it is set."""
        return None if self._skeleton is None else self._skeleton._servant

    def _servant_failed(self, operation: str, error: BaseException) -> None:
        self._component._servant_failed(f"{self.port}.{operation}", error)

    @property
    def reachable(self) -> bool:
        """See `Carrier`."""
        return True

    @property
    def owner(self) -> str:
        """The instance name of the component."""
        return self._component.instance_name

    @property
    def exists(self) -> bool:
        """Whether calls are served: the component's state allows it, and a servant is set."""
        return self._serves and self._skeleton is not None

    @property
    def _serves(self) -> bool:
        component = self._component
        return component.is_alive() if self.in_every_state else component.is_active

    def call(self, operation: str, arguments: tuple[object, ...]) -> object:
        """Make a call with copies of arguments and result.

        Raises as `carry_out` does; in a call that is checked CdrError for arguments that their
        types do not allow, and MarshalError for such a result.
        """
        remaining = self._unchecked.get(operation)
        if remaining is None:
            remaining = self._unchecked[operation] = count_of(self._check)
        if remaining:
            self._unchecked[operation] = remaining - 1
            return self._call_checked(operation, arguments)
        return _snapshot(self.carry_out(operation, _snapshot(arguments)))

    def check_values(self, check: CheckValues) -> None:
        """Set which calls within the process are checked from now on."""
        self._check = check
        self._unchecked.clear()

    def check_next(self) -> None:
        """Check the next call of each operation, if only some are checked."""
        if self._check is CheckValues.FIRST:
            for operation, remaining in self._unchecked.items():
                self._unchecked[operation] = remaining or 1

    def _call_checked(self, operation: str, arguments: tuple[object, ...]) -> object:
        if self._checks is None:
            from rtgen.runtime.services.checking import CallChecks

            self._checks = CallChecks(self.interface, str(self))
        self._checks.arguments(operation, arguments)
        try:
            result = self.carry_out(operation, _snapshot(arguments))
        except UserException as error:
            self._checks.exception(operation, error)
            raise
        self._checks.result(operation, result)
        return _snapshot(result)

    def carry_out(self, operation: str, arguments: tuple[object, ...]) -> object:
        """Make a call. Raises what the IDL declares, ObjectNotExist or UnknownException.

        ObjectNotExist: the component is not ACTIVE (see `in_every_state`), or has no servant.
        """
        if not self._serves:
            raise ObjectNotExist(
                f"{self} is not active, so {operation!r} cannot be called"
            )
        if self._skeleton is None:
            raise ObjectNotExist(
                f"{self} has no servant, so {operation!r} cannot be called"
            )
        return self._skeleton.dispatch(operation, arguments)


class Consumer(Generic[S]):
    """An interface required by a component; connected to at most one provider at a time.

    Operations are called on the consumer itself (`self.motor.stop()`), or on its typed `object`.
    They raise ObjectNotExist without an ACTIVE provider.
    """

    __slots__ = (
        "_provider",
        "_stub",
        "_type_name",
        "instance",
        "interface",
        "owner",
        "port",
    )

    def __init__(
        self,
        port: str,
        instance: str,
        interface: type[S],
        owner: str,
        type_name: str = "",
    ) -> None:
        self.port = port
        self.instance = instance
        self._type_name = type_name
        self.interface = interface
        self.owner = owner
        self._provider: Carrier | None = None
        self._stub: S = interface._stub_(self._call)

    def __str__(self) -> str:
        return f"{self.owner}.{self.port}:{self.instance}"

    def _call(self, operation: str, arguments: tuple[object, ...]) -> object:
        provider = self._provider
        if provider is None:
            raise ObjectNotExist(
                f"{self} is not connected, so {operation!r} cannot be called"
            )
        if provider.__class__ is not Provider:
            step_aside()
        return provider.call(operation, arguments)

    def __getattr__(self, name: str) -> Any:
        """Return an operation or attribute of the interface, as `object` does."""
        if name.startswith("__") or name == "_stub":
            raise AttributeError(name)
        return getattr(self._stub, name)

    @property
    def connected(self) -> bool:
        """Whether there is a provider, ACTIVE or not."""
        return self._provider is not None and self._provider.reachable

    @property
    def object(self) -> S:
        """The typed stub. Its operations raise ObjectNotExist without an ACTIVE provider."""
        return self._stub


class ServicePort:
    """The interfaces of one service port of a component, of both polarities."""

    def __init__(self, component: PortOwner, name: str) -> None:
        self.name = f"{component.instance_name}.{name}"
        self.instance = component.instance_name
        self.port = name
        self.providers = [
            p for (port, _), p in component.providers.items() if port == name
        ]
        self.consumers = [
            c for (port, _), c in component.consumers.items() if port == name
        ]

    def __bool__(self) -> bool:
        return bool(self.providers or self.consumers)

    def __str__(self) -> str:
        return self.name


def _snapshot(value: object) -> Any:
    if isinstance(value, list):
        return [_snapshot(item) for item in value]
    if isinstance(value, tuple):
        return tuple(_snapshot(item) for item in value)
    if isinstance(value, bytearray):
        return bytes(value)
    if isinstance(value, memoryview):
        return bytes(value) if value.format in ("B", "c") else copied(value)
    if isinstance(value, array) or hasattr(value, "dtype"):
        return copied(value)
    copy = getattr(value, "_snapshot_", None)
    return value if copy is None else copy()
