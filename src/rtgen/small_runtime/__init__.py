# mypy: allow-untyped-defs, allow-incomplete-defs, allow-untyped-calls
"""The small runtime: components, ports and codecs for boards.

The same behaviours run here as on the embedded runtime, since names, callbacks and the life cycle
are the same. All buffers have a fixed size and are made when a system is put together; there are no
threads. Only modules that MicroPython has are imported.
"""

import struct
from array import array

SECOND = 1_000_000_000

RTC_OK = 0
RTC_ERROR = 1
BAD_PARAMETER = 2
UNSUPPORTED = 3
OUT_OF_RESOURCES = 4
PRECONDITION_NOT_MET = 5
ReturnCode_t = int

CREATED_STATE = 0
INACTIVE_STATE = 1
ACTIVE_STATE = 2
ERROR_STATE = 3

_ACTIVATE = 1
_DEACTIVATE = 2
_RESET = 3
_CODES = (
    "RTC_OK",
    "RTC_ERROR",
    "BAD_PARAMETER",
    "UNSUPPORTED",
    "OUT_OF_RESOURCES",
    "PRECONDITION_NOT_MET",
)


class PortStatus:
    """What `OutPort.write` answers."""

    PORT_OK = 0
    PRECONDITION_NOT_MET = 5


PORT_OK = PortStatus.PORT_OK


class SizeError(ValueError):
    """A value that is larger than the room that was set aside for it."""


class CodecError(ValueError):
    """Octets that are no value of the type, or a buffer that is too short."""


class Numbers:
    """A sequence of numbers of one `array` type code, in an array that never grows."""

    __slots__ = ("_items", "_length")

    def __init__(self, code: str, room: int, length: int = 0) -> None:
        self._items: array[float] = array(code, [0] * room)
        self._length = length

    def __len__(self) -> int:
        return self._length

    def __getitem__(self, index: int) -> float:
        return self._items[_place(index, self._length)]

    def __setitem__(self, index: int, value: float) -> None:
        self._items[_place(index, self._length)] = value

    def clear(self) -> None:
        """Make it empty."""
        self._length = 0

    def append(self, value: float) -> None:
        """Add a number. Raises SizeError when it is full."""
        if self._length >= len(self._items):
            raise SizeError(f"no room for more than {len(self._items)} items")
        self._items[self._length] = value
        self._length += 1


class Values:
    """A sequence of texts or structs in a list that never grows.

    With `make` its items are structs that are filled in place; else texts of at most `most` octets
    of UTF-8, and `None` marks what is free.
    """

    __slots__ = ("_items", "_length", "_make", "_most")

    def __init__(
        self, make: "type | None", room: int, length: int = 0, most: int = 0
    ) -> None:
        self._make = make
        self._most = most
        self._items: list[object] = [make() if make else None for _ in range(room)]
        self._length = length

    def __len__(self) -> int:
        return self._length

    def __getitem__(self, index: int) -> object:
        return self._items[_place(index, self._length)]

    def __setitem__(self, index: int, value: object) -> None:
        self._put(_place(index, self._length), value)

    def clear(self) -> None:
        """Make it empty."""
        self._length = 0

    def append(self, value: object) -> None:
        """Add an item, structs by value. Raises SizeError when it is full."""
        if self._length >= len(self._items):
            raise SizeError(f"no room for more than {len(self._items)} items")
        self._put(self._length, value)
        self._length += 1

    def next_free(self) -> object:
        """The struct behind the last, which from now on belongs to it. Raises SizeError."""
        if self._length >= len(self._items):
            raise SizeError(f"no room for more than {len(self._items)} items")
        self._length += 1
        return self._items[self._length - 1]

    def _put(self, place: int, value: object) -> None:
        if self._make:
            self._items[place]._copy_(value)  # type: ignore[attr-defined]
        else:
            self._items[place] = bounded(value, self._most)


def _place(index: int, length: int) -> int:
    if index < 0:
        index += length
    if not 0 <= index < length:
        raise IndexError("index out of range")
    return index


def copy_items(target, source) -> None:
    """Replaces the items of a sequence by those of another one or of a list. Raises SizeError."""
    if target is source:
        return
    target.clear()
    for i in range(len(source)):
        target.append(source[i])


def copy_array(target, source) -> None:
    """The same for an array, whose length is fixed. Raises SizeError."""
    if len(source) != len(target):
        raise SizeError(f"{len(source)} items for an array of {len(target)}")
    for i in range(len(target)):
        target[i] = source[i]


def bounded(value, most: int):
    """Octets, or a text in UTF-8, that are at most so long. Raises SizeError."""
    length = len(value.encode()) if isinstance(value, str) else len(value)
    if length > most:
        raise SizeError(f"{length} octets, room for {most}")
    return value


_NOT_PACKED = (getattr(struct, "error", ValueError), ValueError, OverflowError)
"""What `struct` raises; MicroPython's has no error of its own."""


def exactly(value, length: int):
    """Octets of an array, which are exactly so many. Raises SizeError."""
    if len(value) != length:
        raise SizeError(f"{len(value)} octets for an array of {length}")
    return value


class Wire:
    """CDR, little-endian, in a buffer that was made once. `at` is the next place."""

    __slots__ = ("at", "buffer", "end")

    def __init__(self, buffer: bytearray, end: int = -1) -> None:
        self.buffer = buffer
        self.at = 0
        self.end = len(buffer) if end < 0 else end

    def put(self, form: str, size: int, value: float) -> None:
        """A number of that form and size. Raises CodecError."""
        self._align(size)
        if self.at + size > self.end:
            raise CodecError("the buffer is too short")
        try:
            struct.pack_into(form, self.buffer, self.at, value)
        except _NOT_PACKED as error:
            raise CodecError(str(error)) from error
        self.at += size

    def take(self, form: str, size: int):
        """The next number. Raises CodecError."""
        self._align(size)
        if self.at + size > self.end:
            raise CodecError("the octets end too early")
        value = struct.unpack_from(form, self.buffer, self.at)[0]
        self.at += size
        return value

    def _align(self, size: int) -> None:
        while self.at % size:
            if self.at < self.end:
                self.buffer[self.at] = 0
            self.at += 1

    def take_boolean(self) -> bool:
        """The next boolean. Raises CodecError."""
        value = self.take("<B", 1)
        if value > 1:
            raise CodecError(f"{value} is no boolean")
        return bool(value)

    def put_octets(self, value: bytes) -> None:
        """Octets as they are. Raises CodecError."""
        end = self.at + len(value)
        if end > self.end:
            raise CodecError("the buffer is too short")
        self.buffer[self.at : end] = value
        self.at = end

    def take_octets(self, length: int) -> bytes:
        """So many octets. Raises CodecError."""
        end = self.at + length
        if end > self.end:
            raise CodecError("the octets end too early")
        value = bytes(self.buffer[self.at : end])
        self.at = end
        return value

    def put_string(self, value: str) -> None:
        """A string. Raises CodecError."""
        octets = value.encode()
        if b"\x00" in octets:
            raise CodecError("a string cannot hold NUL")
        self.put("<I", 4, len(octets) + 1)
        self.put_octets(octets)
        self.put("<B", 1, 0)

    def take_string(self, most: int) -> str:
        """The next string, of at most so many octets of UTF-8. Raises CodecError."""
        length = self.take_count(most + 1)
        octets = self.take_octets(length)
        if not octets or octets[-1]:
            raise CodecError("a string does not end with NUL")
        try:
            text = octets[:-1].decode()
        except UnicodeError as error:
            raise CodecError("a string is no UTF-8") from error
        if "\x00" in text:
            raise CodecError("a string cannot hold NUL")
        return text

    def take_count(self, most: int) -> int:
        """The count in front of a sequence. Raises CodecError."""
        count = self.take("<I", 4)
        if count > most:
            raise CodecError(f"{count} items, room for {most}")
        return int(count)


def to_cdr(sample, buffer: bytearray) -> int:
    """Writes a sample as CDR, little-endian; returns how many octets. Raises CodecError."""
    wire = Wire(buffer)
    sample._put_(wire)
    return wire.at


def from_cdr(sample, buffer: bytearray, length: int) -> None:
    """Fills a sample from CDR, little-endian, of exactly that length. Raises CodecError."""
    wire = Wire(buffer, length)
    sample._take_(wire)
    if wire.at != length:
        raise CodecError(f"{length - wire.at} octets too many")


class InPort:
    """The receiving end: a ring of samples that are filled in place; the oldest is overwritten.

    What `read` returns is the port's own object: the next `read` fills it anew.
    """

    def __init__(self, name: str, type_: type, owner: str, room: int) -> None:
        self.name = name
        self.type = type_
        self.owner = owner
        self.lost = 0
        self._ring = [type_() for _ in range(room)]
        self._first = 0
        self._unread = 0
        self._last = type_()
        self._any = False

    def is_new(self) -> bool:
        """Whether there is an unread sample."""
        return self._unread > 0

    def read(self):
        """The oldest unread sample, else the last one again; None if there was none."""
        if self._unread:
            self._last._copy_(self._ring[self._first])
            self._first = (self._first + 1) % len(self._ring)
            self._unread -= 1
            self._any = True
        return self._last if self._any else None

    def read_newest(self):
        """The newest unread sample, None if there is none; older ones count as read."""
        if not self._unread:
            return None
        newest = (self._first + self._unread - 1) % len(self._ring)
        self._last._copy_(self._ring[newest])
        self._unread = 0
        self._any = True
        return self._last

    def take_in(self, sample: object) -> None:
        """Notes a sample, by value."""
        room = len(self._ring)
        if self._unread == room:
            self._first = (self._first + 1) % room
            self._unread -= 1
            self.lost += 1
        self._ring[(self._first + self._unread) % room]._copy_(sample)
        self._unread += 1


class OutPort:
    """The sending end."""

    def __init__(self, name: str, type_: type, owner: str) -> None:
        self.name = name
        self.type = type_
        self.owner = owner
        self.unsent = 0
        self._targets: list[InPort] = []

    def write(self, sample: object) -> int:
        """Sends a sample, by value. Raises SizeError for one that has no room."""
        if not self._targets:
            self.unsent += 1
            return PortStatus.PRECONDITION_NOT_MET
        for target in self._targets:
            target.take_in(sample)
        return PORT_OK

    def connect(self, target: InPort) -> None:
        """Joins an InPort. Raises TypeError for one of another type, ValueError if it is joined."""
        if target.type is not self.type:
            raise TypeError(
                f"{self.owner}.{self.name} sends {self.type.__name__},"
                f" {target.owner}.{target.name} takes {target.type.__name__}"
            )
        if target in self._targets:
            raise ValueError(
                f"{self.owner}.{self.name} is joined with {target.owner}.{target.name}"
            )
        self._targets.append(target)


class Component:
    """The base of every component; what callbacks return and do is as on the embedded runtime."""

    # What ports may be called is not taken: the rest of the runtime's own begins with `_`.
    _type_name = "Component"
    _rate = 1000.0
    _buffer = 8

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

    def add_in_port(self, name: str, type_: type) -> InPort:
        """Adds an InPort with its buffer."""
        port = InPort(name, type_, self.instance_name, self._buffer)
        self.in_ports[name] = port
        return port

    def add_out_port(self, name: str, type_: type) -> OutPort:
        """Adds an OutPort."""
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
        """The time in ns."""
        return self._now

    def stamp(self, sample) -> None:
        """Fills `sample.tm` from `now`."""
        sample.tm.sec, sample.tm.nsec = divmod(self._now, SECOND)

    def fail(self, reason: str) -> int:
        """Notes why a callback fails; returns RTC_ERROR, to be returned by the callback."""
        self._failing = reason
        return RTC_ERROR

    def _configure(self, name: str, text: str) -> None:
        config = self.config  # type: ignore[attr-defined]
        if name not in config.__slots__:
            raise ValueError("there is no parameter " + name)
        before = getattr(config, name)
        if isinstance(before, bool):
            if text not in ("true", "false", "1", "0"):
                raise ValueError(text + " is no boolean")
            setattr(config, name, text in ("true", "1"))
        else:
            setattr(config, name, type(before)(text))

    # One tick, as the embedded runtime has it.

    def _cycle(self, now: int) -> None:
        self._now = now
        before = self._state
        for _ in range(len(self._requests)):
            self._carry_out(self._requests.pop(0))
        if self._state == ERROR_STATE:
            if before == ERROR_STATE:
                self._call("on_error", 0)
        elif self._state == ACTIVE_STATE:
            self._ticks += 1
            if not (self._call("on_execute", 0) and self._call("on_state_update", 0)):
                self._enter_error()

    def _request(self, request: int) -> int:
        needed = (INACTIVE_STATE, ACTIVE_STATE, ERROR_STATE)[request - 1]
        if self._state != needed:
            return PRECONDITION_NOT_MET
        if request not in self._requests:
            self._requests.append(request)
        return RTC_OK

    def _carry_out(self, request: int) -> None:
        if request == _ACTIVATE and self._state == INACTIVE_STATE:
            if self._call("on_activated", 0):
                self._state = ACTIVE_STATE
            else:
                self._enter_error()
        elif request == _DEACTIVATE and self._state == ACTIVE_STATE:
            self._call("on_deactivated", 0)
            self._state = INACTIVE_STATE
        elif (
            request == _RESET
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
            told, kind = str(error), type(error).__name__
            self._note(
                callback, callback + ": " + (kind + ": " + told if told else kind)
            )
            return False
        # Neither None nor False is RTC_OK: whoever forgets the answer has failed.
        if type(code) is int and code == RTC_OK:
            return True
        known = type(code) is int and 0 <= code < len(_CODES)
        shown = _CODES[code] if known else repr(code)
        self._note(callback, self._failing or callback + ": returned " + shown)
        return False

    def _note(self, callback: str, reason: str) -> None:
        if callback not in ("on_aborting", "on_error"):
            self.reason = reason


class System:
    """Components on one clock. At equal instants the order in which they were added decides.

    `wait` is called with the nanoseconds until the next tick; without it time is simulated.
    """

    def __init__(self, wait=None) -> None:
        self.time = 0
        self._wait = wait
        self._components: list[Component] = []
        self._periods: list[int] = []
        self._due: list[int] = []

    def add(self, component: Component, rate: "float | None" = None) -> None:
        """Adds a component at a rate [Hz], its own unless given. Raises ValueError."""
        hertz = component._rate if rate is None else rate
        if not 0.0 < hertz <= SECOND:
            raise ValueError("the rate must be a number of Hz above 0")
        component._now = self.time
        if not component._call("on_initialize"):
            raise ValueError(component.instance_name + ": " + component.reason)
        component._state = INACTIVE_STATE
        component._call("on_startup", 0)
        self._components.append(component)
        self._periods.append(round(SECOND / hertz))
        self._due.append(self.time)

    def configure(self, component: Component, name: str, text: str) -> None:
        """Sets a parameter by its name in Python. Raises ValueError."""
        component._configure(name, text)

    def state(self, component: Component) -> int:
        """The state of a component."""
        return component._state

    def ticks(self, component: Component) -> int:
        """How often `on_execute` was called."""
        return component._ticks

    def activate(self, component: Component) -> int:
        """Requests ACTIVE."""
        return component._request(_ACTIVATE)

    def deactivate(self, component: Component) -> int:
        """Requests INACTIVE."""
        return component._request(_DEACTIVATE)

    def reset(self, component: Component) -> int:
        """Requests INACTIVE after an error."""
        return component._request(_RESET)

    def run(self, until: int) -> None:
        """Runs until an instant [ns since the start], which does not belong to the run."""
        due = self._due
        while due and min(due) < until:
            instant = min(due)
            if self._wait is not None:
                self._wait(instant - self.time)
            self.time = instant
            for i in range(len(due)):
                if due[i] == instant:
                    due[i] = instant + self._periods[i]
                    self._components[i]._cycle(instant)
        self.time = until

    def close(self) -> None:
        """Ends the life of all components, the one added last first, deactivated if need be."""
        while self._components:
            component = self._components.pop()
            self._periods.pop()
            self._due.pop()
            if component._state == ACTIVE_STATE:
                component._carry_out(_DEACTIVATE)
            component._call("on_shutdown", 0)
            component._call("on_finalize")
            component._state = CREATED_STATE
