"""A cache of fixed size. Also for small boards."""


class Recent:
    """Slots for the recently used keys; their number is fixed."""

    def __init__(self, room: int) -> None:
        self._keys = [b""] * room
        self._used = [0] * room
        self._clock = 0

    def find(self, key: bytes) -> int:
        """Return the slot of a key, -1 if it has none."""
        for place in range(len(self._keys)):
            if self._used[place] and self._keys[place] == key:
                self._touch(place)
                return place
        return -1

    def take(self, key: bytes) -> int:
        """Return a slot for a new key: the least recently used one."""
        oldest = 0
        for place in range(len(self._keys)):
            if self._used[place] < self._used[oldest]:
                oldest = place
        self._keys[oldest] = key
        self._touch(oldest)
        return oldest

    def _touch(self, place: int) -> None:
        self._clock += 1
        self._used[place] = self._clock


def octets_of(digits: str) -> bytes:
    """Return the 16 octets of a ucode in hexadecimal digits, padded with 0. Raises ValueError."""
    if not 0 < len(digits) <= 32:
        raise ValueError(digits + " is not a ucode of 1 to 32 hexadecimal digits")
    number = int(digits, 16)
    return number.to_bytes(16, "big")


def entries(text: str) -> "list[list[str]]":
    """Return the words of each entry of a text with semicolons."""
    parts = [part.split() for part in text.split(";")]
    return [words for words in parts if words]
