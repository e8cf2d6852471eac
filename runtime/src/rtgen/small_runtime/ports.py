# mypy: allow-untyped-defs, allow-incomplete-defs, allow-untyped-calls
"""Data ports: samples are copied into a ring buffer that is allocated once."""

from .codes import PORT_OK, PortStatus


class InPort:
    """The receiving end: a ring buffer of samples; when full, the oldest is overwritten.

    The port reuses the object that `read` returns: the next `read` overwrites it.
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
        self._arrived = lambda: None  # called after each sample

    def is_new(self) -> bool:
        """Return whether there is an unread sample."""
        return self._unread > 0

    def read(self):
        """Return the oldest unread sample, else the last one again; None if there was none."""
        if self._unread:
            self._last._copy_(self._ring[self._first])
            self._first = (self._first + 1) % len(self._ring)
            self._unread -= 1
            self._any = True
        return self._last if self._any else None

    def read_newest(self):
        """Return the newest unread sample, None without one; older ones count as read."""
        if not self._unread:
            return None
        newest = (self._first + self._unread - 1) % len(self._ring)
        self._last._copy_(self._ring[newest])
        self._unread = 0
        self._any = True
        return self._last

    def take_in(self, sample: object) -> None:
        """Store a copy of a sample."""
        room = len(self._ring)
        if self._unread == room:
            self._first = (self._first + 1) % room
            self._unread -= 1
            self.lost += 1
        self._ring[(self._first + self._unread) % room]._copy_(sample)
        self._unread += 1
        self._arrived()


class OutPort:
    """The sending end."""

    def __init__(self, name: str, type_: type, owner: str) -> None:
        self.name = name
        self.type = type_
        self.owner = owner
        self.unsent = 0
        self._targets: list[InPort] = []

    def write(self, sample: object) -> int:
        """Send a copy of a sample. Raises SizeError for one that is too large."""
        if not self._targets:
            self.unsent += 1
            return PortStatus.PRECONDITION_NOT_MET
        for target in self._targets:
            target.take_in(sample)
        return PORT_OK

    def connect(self, target: InPort) -> None:
        """Connect an InPort. Raises TypeError for another type, ValueError if it is connected."""
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
