"""Conversion between frames and the messages of python-can, which is imported at first use."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rtgen.runtime.canopen.wire.frames import MAX_DATA, Frame

if TYPE_CHECKING:
    import can


def frame_of(message: can.Message) -> Frame | None:
    """Convert a message to a frame; None if it is not a frame of classical CAN."""
    if message.is_error_frame or message.is_fd or message.dlc > MAX_DATA:
        return None
    data = b"" if message.is_remote_frame else bytes(message.data)
    try:
        return Frame(
            message.arbitration_id,
            data,
            message.is_remote_frame,
            message.is_extended_id,
        )
    except ValueError:
        return None


def message_of(frame: Frame, timestamp: float = 0.0) -> can.Message:
    """Convert a frame to a message; `timestamp` in s, 0 for a message to send."""
    import can

    return can.Message(
        timestamp=timestamp,
        arbitration_id=frame.can_id,
        data=None if frame.remote else frame.data,
        is_extended_id=frame.extended,
        is_remote_frame=frame.remote,
        is_rx=timestamp > 0,
        check=False,
    )
