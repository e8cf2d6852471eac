"""Reads what candump prints: its log (`candump -L`) and its screen output (can-utils, lib.c)."""

from __future__ import annotations

import re
from datetime import datetime
from math import isfinite
from typing import TYPE_CHECKING, Any

from rtgen.facts.canopen import MAX_EXTENDED_ID, MAX_STANDARD_ID
from rtgen.runtime.canopen.wire.frames import MAX_DATA

if TYPE_CHECKING:
    from can import Message

ERROR_FLAG = 0x20000000
"""Marks an error frame in an identifier (linux/can.h, CAN_ERR_FLAG)."""
_BIT_RATE_SWITCH = 0x01
_ERROR_STATE = 0x02

_ID = r"(?P<id>[0-9A-F]{8}|[0-9A-F]{3})"
_LOG = re.compile(
    rf"\((?P<time>[^)]+)\)\s+(?P<channel>\S+)\s+{_ID}#"
    r"(?:(?P<remote>R)(?P<length>[0-8]?)|(?:\#(?P<flags>[0-9A-F]))?"
    r"(?P<data>(?:[0-9A-F]{2}\.?)*))(?:_[9A-F])?(?:\s+[RT])?",
    re.IGNORECASE,
)
_SCREEN = re.compile(
    rf"(?:\((?P<time>[^)]+)\)\s+)?(?P<channel>\S+)\s+(?:[RT]X\s+\S\s+\S\s+)?{_ID}\s+"
    r"\[(?P<length>\d{1,2})\](?:\s+(?P<remote>remote request)|(?P<data>(?:\s+[0-9A-F]{2})*))"
    r"(?:\s+ERRORFRAME|\s+'.*')?",
    re.IGNORECASE,
)
_COLOUR = re.compile(r"\x1b\[[0-9;]*m")


def message_of_line(line: str) -> Message:
    """Return the frame of a line; one without a time has the time 0. Raises ValueError."""
    text = _COLOUR.sub("", line).strip()
    parts = _LOG.fullmatch(text)
    if parts is not None:
        return _message(parts, is_fd=parts["flags"] is not None, length=None)
    parts = _SCREEN.fullmatch(text)
    if parts is None:
        raise ValueError("this is not a frame")
    # Only lengths of CAN FD have two digits.
    return _message(parts, is_fd=len(parts["length"]) > 1, length=int(parts["length"]))


def _message(parts: re.Match[str], *, is_fd: bool, length: int | None) -> Message:
    from can import Message

    can_id, is_extended = int(parts["id"], 16), len(parts["id"]) > 3
    groups = parts.groupdict()
    data = bytes.fromhex((parts["data"] or "").replace(".", ""))
    remote = parts["remote"] is not None
    if length is not None and not remote and length != len(data):
        raise ValueError(f"{len(data)} octets where the line says {length}")
    fields: dict[str, Any] = {
        "timestamp": _time(parts["time"]),
        "channel": parts["channel"],
    }
    if is_extended and can_id & ERROR_FLAG:
        return Message(
            is_error_frame=True,
            arbitration_id=can_id & ~ERROR_FLAG & MAX_EXTENDED_ID,
            data=data[:MAX_DATA],
            **fields,
        )
    if can_id > (MAX_EXTENDED_ID if is_extended else MAX_STANDARD_ID):
        raise ValueError(f"{parts['id']} is not an identifier")
    flags = int(groups.get("flags") or "0", 16)
    return Message(
        arbitration_id=can_id,
        is_extended_id=is_extended,
        is_remote_frame=remote,
        dlc=min(int(parts["length"] or "0", 16), MAX_DATA) if remote else len(data),
        data=None if remote else data,
        is_fd=is_fd,
        bitrate_switch=is_fd and bool(flags & _BIT_RATE_SWITCH),
        error_state_indicator=is_fd and bool(flags & _ERROR_STATE),
        check=True,
        **fields,
    )


def _time(text: str | None) -> float:
    if text is None:
        return 0.0
    try:
        time = float(text)
    except ValueError:
        time = datetime.fromisoformat(text).timestamp()
    if not isfinite(time) or time < 0.0:
        raise ValueError(f"{text} is not a time")
    return time
