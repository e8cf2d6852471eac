# mypy: allow-untyped-defs, allow-incomplete-defs, allow-untyped-calls
"""Components: callbacks, parameters, and the life cycle."""

from .codes import (
    ACTIVATE,
    ACTIVE_STATE,
    CODE_NAMES,
    CREATED_STATE,
    DEACTIVATE,
    ERROR_STATE,
    INACTIVE_STATE,
    PRECONDITION_NOT_MET,
    RESET,
    RTC_ERROR,
    RTC_OK,
    SECOND,
)
from .ports import InPort, OutPort


class Component:
    """Base class of components; callbacks have the same meaning as on the embedded runtime."""

    # Names that ports can have are kept free: the runtime's own names start with `_`.
    _type_name = "Component"
    _rate = 1000.0
    _buffer = 8
    _triggers: "tuple[str, ...] | None" = None
    # The InPorts whose samples execute it, none: all; None: it is executed at its ticks.

    def __init__(self, instance_name: "str | None" = None) -> None:
        self.instance_name = instance_name or self._type_name + "0"
        self.reason = ""
        self.in_ports: dict[str, InPort] = {}
        self.out_ports: dict[str, OutPort] = {}
        self.observables: dict[str, object] = {}
        self._state = CREATED_STATE
        self._ticks = 0
        self._failing = ""
        self._now = 0
        self._requests: list[int] = []
        self._wake = lambda: None

    def add_in_port(self, name: str, type_: type) -> InPort:
        """Add an InPort with its buffer."""
        port = InPort(name, type_, self.instance_name, self._buffer)
        self.in_ports[name] = port
        return port

    def add_out_port(self, name: str, type_: type) -> OutPort:
        """Add an OutPort."""
        port = OutPort(name, type_, self.instance_name)
        self.out_ports[name] = port
        return port

    def on_initialize(self) -> int:
        """Called once, when the component joins a system; a failure keeps it out."""
        return RTC_OK

    def on_finalize(self) -> int:
        """Called once, when the component leaves."""
        return RTC_OK

    def on_startup(self, ec_id: int) -> int:
        """Called when the component has joined a system; a failure changes nothing."""
        return RTC_OK

    def on_shutdown(self, ec_id: int) -> int:
        """Called before the component leaves; a failure changes nothing."""
        return RTC_OK

    def on_activated(self, ec_id: int) -> int:
        """Called on the way from INACTIVE to ACTIVE; a failure leads to ERROR."""
        return RTC_OK

    def on_deactivated(self, ec_id: int) -> int:
        """Called on the way from ACTIVE to INACTIVE."""
        return RTC_OK

    def on_aborting(self, ec_id: int) -> int:
        """Called when ERROR is entered."""
        return RTC_OK

    def on_error(self, ec_id: int) -> int:
        """Called at every tick in ERROR."""
        return RTC_OK

    def on_reset(self, ec_id: int) -> int:
        """Called on the way from ERROR to INACTIVE; after a failure it stays in ERROR."""
        return RTC_OK

    def on_execute(self, ec_id: int) -> int:
        """Called at every tick while ACTIVE; a failure leads to ERROR."""
        return RTC_OK

    def on_state_update(self, ec_id: int) -> int:
        """Called at every tick while ACTIVE, after `on_execute`; a failure leads to ERROR."""
        return RTC_OK

    @property
    def is_active(self) -> bool:
        """Whether the component is ACTIVE."""
        return self._state == ACTIVE_STATE

    @property
    def lost(self) -> int:
        """Samples that were overwritten in the component's InPorts."""
        return sum(port.lost for port in self.in_ports.values())

    def now(self) -> int:
        """Return the time in ns."""
        return self._now

    def stamp(self, sample) -> None:
        """Set `sample.tm` to `now`."""
        sample.tm.sec, sample.tm.nsec = divmod(self._now, SECOND)

    def fail(self, reason: str) -> int:
        """Set the reason of a failure; return RTC_ERROR, for the callback to return."""
        self._failing = reason
        return RTC_ERROR

    def _configure(self, name: str, text: str) -> None:
        config = self.config  # type: ignore[attr-defined]
        if name not in config.__slots__:
            raise ValueError("there is no parameter " + name)
        before = getattr(config, name)
        if isinstance(before, bool):
            if text not in ("true", "false", "1", "0"):
                raise ValueError(text + " is not a boolean")
            setattr(config, name, text in ("true", "1"))
        else:
            setattr(config, name, type(before)(text))

    # Ticks, executed as on the embedded runtime

    def _cycle(self, now: int) -> None:
        self._now = now
        before = self._state
        for _ in range(len(self._requests)):
            self._carry_out(self._requests.pop(0))
        if self._state == ERROR_STATE:
            if before == ERROR_STATE:
                self._call("on_error", 0)
        elif self._state == ACTIVE_STATE:
            if self._triggers is None:
                self._execute()
            elif before != ACTIVE_STATE and self._take_samples(now):
                self._wake()

    def _execute(self) -> None:
        self._ticks += 1
        if not (self._call("on_execute", 0) and self._call("on_state_update", 0)):
            self._enter_error()

    def _take_samples(self, now: int) -> bool:
        """Execute if samples wait; return whether some were read, and others are left."""
        self._now = now
        before = self._unread()
        if self._state != ACTIVE_STATE or not before:
            return False
        self._execute()
        return 0 < self._unread() < before

    def _unread(self) -> int:
        return sum(port._unread for port in self._trigger_ports())

    def _trigger_ports(self) -> "list[InPort]":
        names = self._triggers or self.in_ports
        return [port for name, port in self.in_ports.items() if name in names]

    def _request(self, request: int) -> int:
        needed = (INACTIVE_STATE, ACTIVE_STATE, ERROR_STATE)[request - 1]
        if self._state != needed:
            return PRECONDITION_NOT_MET
        if request not in self._requests:
            self._requests.append(request)
        return RTC_OK

    def _carry_out(self, request: int) -> None:
        if request == ACTIVATE and self._state == INACTIVE_STATE:
            if self._call("on_activated", 0):
                self._state = ACTIVE_STATE
            else:
                self._enter_error()
        elif request == DEACTIVATE and self._state == ACTIVE_STATE:
            self._call("on_deactivated", 0)
            self._state = INACTIVE_STATE
        elif (
            request == RESET
            and self._state == ERROR_STATE
            and self._call("on_reset", 0)
        ):
            self._state = INACTIVE_STATE
            self.reason = ""

    def _enter_error(self) -> None:
        self._state = ERROR_STATE
        self._call("on_aborting", 0)

    def _call(self, callback: str, *arguments: int) -> bool:
        self._failing = ""
        try:
            code = getattr(self, callback)(*arguments)
        except Exception as error:
            message, kind = str(error), type(error).__name__
            self._note(
                callback, callback + ": " + (kind + ": " + message if message else kind)
            )
            return False
        # None and False are not RTC_OK: a callback without a return value has failed.
        if type(code) is int and code == RTC_OK:
            return True
        is_code = type(code) is int and 0 <= code < len(CODE_NAMES)
        shown = CODE_NAMES[code] if is_code else repr(code)
        self._note(callback, self._failing or callback + ": returned " + shown)
        return False

    def _note(self, callback: str, reason: str) -> None:
        if callback not in ("on_aborting", "on_error"):
            self.reason = reason
