"""The formats of compiled codecs: classic CDR, the versions of XCDR, keys."""

from __future__ import annotations

from typing import NamedTuple


class Format(NamedTuple):
    """Classic CDR (version 0), or XCDR version 1 or 2 (DDS-XTypes 1.3, 7.4.3.2).

    `key`: only the key of a value, members by id, without headers (7.6.8). `ros2`: classic CDR in
    which each UTF-16 unit of a `wstring` has four octets, after their number, as rmw writes it.
    """

    version: int
    key: bool = False
    ros2: bool = False

    @property
    def widest(self) -> int:
        """The largest alignment."""
        return 4 if self.version == 2 else 8

    def __str__(self) -> str:
        name = f"XCDR{self.version}" if self.version else "CDR"
        if self.ros2:
            return "CDR of ROS 2"
        return f"{name} key" if self.key else name


CLASSIC = Format(0)
ROS2 = Format(0, ros2=True)


class UnsupportedError(TypeError):
    """A type that has no representation in the format."""
