"""Conversions between data of RT-Middleware and messages of ROS 2, for generated adapters.

Each fills its second argument from the first. Units are SI on both sides: m, rad, s. Members
without a counterpart keep their values: frames, covariances, ids.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from operator import attrgetter
from typing import Any, Final, TypeAlias

Convert: TypeAlias = Callable[[Any, Any], None]
_LAST_SECOND: Final = (1 << 31) - 1
"""Maximum of builtin_interfaces/msg/Time, which counts signed 32-bit seconds."""


def time_to_stamp(tm: Any, stamp: Any) -> None:
    """Convert `RTC::Time` to builtin_interfaces/msg/Time; times after 2038 are clipped."""
    stamp.sec, stamp.nanosec = min(tm.sec, _LAST_SECOND), tm.nsec


def time_of_stamp(stamp: Any, tm: Any) -> None:
    """Convert builtin_interfaces/msg/Time to `RTC::Time`; times before 1970 become 0."""
    tm.sec, tm.nsec = (stamp.sec, stamp.nanosec) if stamp.sec >= 0 else (0, 0)


def heading_of(q: Any) -> float:
    """Return the rotation about z of a quaternion, in (-pi, pi] rad; 0 for the zero quaternion."""
    return math.atan2(
        2.0 * (q.w * q.z + q.x * q.y), q.w * q.w + q.x * q.x - q.y * q.y - q.z * q.z
    )


def _pose_to(data: Any, pose: Any) -> None:
    """Convert a Pose2D to geometry_msgs/msg/Pose."""
    pose.position.x, pose.position.y = data.position.x, data.position.y
    pose.position.z = 0.0
    orientation = pose.orientation
    orientation.x = orientation.y = 0.0
    orientation.z, orientation.w = math.sin(data.heading / 2), math.cos(
        data.heading / 2
    )


def _pose_of(pose: Any, data: Any) -> None:
    data.position.x, data.position.y = pose.position.x, pose.position.y
    data.heading = heading_of(pose.orientation)


def _velocity_to(data: Any, twist: Any) -> None:
    twist.linear.x, twist.linear.y, twist.linear.z = data.vx, data.vy, 0.0
    twist.angular.x = twist.angular.y = 0.0
    twist.angular.z = data.va


def _velocity_of(twist: Any, data: Any) -> None:
    data.vx, data.vy, data.va = twist.linear.x, twist.linear.y, twist.angular.z


def _xyz(source: Any, target: Any) -> None:
    target.x, target.y, target.z = source.x, source.y, source.z


def _xyzw(source: Any, target: Any) -> None:
    _xyz(source, target)
    target.w = source.w


def _stamped(part: str, to: Convert, of: Convert) -> tuple[Convert, Convert]:
    """Return the conversions to and of a message with a header, whose `part` are the data."""
    data = attrgetter(part)

    def to_message(sample: Any, made: Any) -> None:
        time_to_stamp(sample.tm, made.header.stamp)
        to(sample.data, data(made))

    def of_message(sample: Any, made: Any) -> None:
        time_of_stamp(sample.header.stamp, made.tm)
        of(data(sample), made.data)

    return to_message, of_message


pose_to_pose_stamped, pose_of_pose_stamped = _stamped("pose", _pose_to, _pose_of)
"""TimedPose2D and geometry_msgs/msg/PoseStamped, whose part in the plane counts."""
pose_to_odometry, pose_of_odometry = _stamped("pose.pose", _pose_to, _pose_of)
"""TimedPose2D and nav_msgs/msg/Odometry; the velocity stays 0."""
velocity_to_twist_stamped, velocity_of_twist_stamped = _stamped(
    "twist", _velocity_to, _velocity_of
)
"""TimedVelocity2D and geometry_msgs/msg/TwistStamped."""
point_to_message, point_of_message = _stamped("point", _xyz, _xyz)
"""TimedPoint3D and geometry_msgs/msg/PointStamped."""
vector_to_message, vector_of_message = _stamped("vector", _xyz, _xyz)
"""TimedVector3D and geometry_msgs/msg/Vector3Stamped."""
quaternion_to_message, quaternion_of_message = _stamped("quaternion", _xyzw, _xyzw)
"""TimedQuaternion and geometry_msgs/msg/QuaternionStamped."""


def velocity_to_twist(sample: Any, made: Any) -> None:
    """Convert TimedVelocity2D to geometry_msgs/msg/Twist."""
    _velocity_to(sample.data, made)


def velocity_of_twist(sample: Any, made: Any) -> None:
    """Convert geometry_msgs/msg/Twist to TimedVelocity2D, whose time the adapter sets."""
    _velocity_of(sample, made.data)


def ranges_to_scan(sample: Any, made: Any) -> None:
    """Convert RangeData to sensor_msgs/msg/LaserScan."""
    config = sample.config
    time_to_stamp(sample.tm, made.header.stamp)
    made.angle_min, made.angle_max = config.minAngle, config.maxAngle
    made.angle_increment = config.angularRes
    made.scan_time = 1.0 / config.frequency if config.frequency > 0 else 0.0
    made.range_min, made.range_max = config.minRange, config.maxRange
    made.ranges = list(sample.ranges)


def ranges_of_scan(sample: Any, made: Any) -> None:
    """Convert sensor_msgs/msg/LaserScan to RangeData."""
    config = made.config
    time_of_stamp(sample.header.stamp, made.tm)
    config.minAngle, config.maxAngle = sample.angle_min, sample.angle_max
    config.angularRes = sample.angle_increment
    config.frequency = 1.0 / sample.scan_time if sample.scan_time > 0 else 0.0
    config.minRange, config.maxRange = sample.range_min, sample.range_max
    made.ranges = list(sample.ranges)


def angles_to_joints(sample: Any, made: Any) -> None:
    """Convert TimedDoubleSeq of angles to sensor_msgs/msg/JointState; the adapter sets names."""
    time_to_stamp(sample.tm, made.header.stamp)
    made.position = list(sample.data)


def angles_of_joints(sample: Any, made: Any) -> None:
    """Convert sensor_msgs/msg/JointState to TimedDoubleSeq: the angles in message order."""
    time_of_stamp(sample.header.stamp, made.tm)
    made.data = list(sample.position)


def data_to_real(sample: Any, made: Any) -> None:
    """Convert a number to a floating-point one."""
    made.data = float(sample.data)


def data_to_integer(sample: Any, made: Any) -> None:
    """Convert a number to an integer, without its fraction. Raises ValueError, OverflowError."""
    made.data = int(sample.data)


def data_to_reals(sample: Any, made: Any) -> None:
    """Convert numbers to floating-point ones; the layout of a multi-array stays empty."""
    made.data = [float(each) for each in sample.data]


def data_to_integers(sample: Any, made: Any) -> None:
    """Convert numbers to integers, without fractions. Raises ValueError, OverflowError."""
    numbers = [int(each) for each in sample.data]
    made.data = bytes(numbers) if isinstance(made.data, bytes) else numbers


def text_to_string(sample: Any, made: Any) -> None:
    """Convert TimedString to std_msgs/msg/String."""
    made.data = sample.data


text_of_string = text_to_string


_ENCODINGS: Final = {8: "mono8", 16: "mono16", 24: "rgb8", 32: "rgba8"}
"""Encodings of images without a format, by bits per pixel."""


def image_to_message(sample: Any, made: Any) -> None:
    """Convert CameraImage to sensor_msgs/msg/Image; `format` is the encoding. Raises ValueError."""
    time_to_stamp(sample.tm, made.header.stamp)
    made.height, made.width = sample.height, sample.width
    made.encoding = sample.format or _ENCODINGS.get(sample.bpp, "")
    if not made.encoding:
        raise ValueError(f"an image of {sample.bpp} bits per pixel needs a format")
    made.step = sample.width * ((sample.bpp + 7) // 8)
    made.data = bytes(sample.pixels)


_BITS: Final = {
    **{encoding: bits for bits, encoding in _ENCODINGS.items()},
    "bgr8": 24,
    "bgra8": 32,
    "rgb16": 48,
    "bgr16": 48,
    "rgba16": 64,
    "bgra16": 64,
}
"""Bits per pixel of the encodings of sensor_msgs/image_encodings."""
_MAX_SIDE: Final = (1 << 16) - 1


def image_of_message(sample: Any, made: Any) -> None:
    """Convert sensor_msgs/msg/Image to CameraImage, whose rows have no padding.

    Raises ValueError for an image that is too large.
    """
    if max(sample.width, sample.height) > _MAX_SIDE:
        raise ValueError(f"{sample.width} by {sample.height} pixels are too many")
    time_of_stamp(sample.header.stamp, made.tm)
    made.height, made.width = sample.height, sample.width
    octets, step = bytes(sample.data), sample.step
    bits = step // sample.width * 8 if sample.width else 0
    made.bpp, made.format = _BITS.get(sample.encoding, bits), sample.encoding
    length = min((made.bpp + 7) // 8 * sample.width, step)
    rows = range(0, min(step * sample.height, len(octets)), step or 1)
    made.pixels = b"".join(octets[row : row + length] for row in rows)


_UNKNOWN: Final = 255
"""Value of an unknown cell; in ROS 2 it is -1."""
_OCCUPIED: Final = 100


def map_to_grid(sample: Any, made: Any) -> None:
    """Convert OccupancyGridMap to nav_msgs/msg/OccupancyGrid: the tile, at its place.

    Cells are 0 to 100, all others unknown. Raises ValueError for cells that are not square.
    """
    config, tile = sample.config, sample.map
    if config.xScale != config.yScale:
        raise ValueError(
            f"cells of {config.xScale} by {config.yScale} m are not square"
        )
    time_to_stamp(sample.tm, made.header.stamp)
    made.info.resolution = config.xScale
    made.info.width, made.info.height = tile.width, tile.height
    along, across = tile.column * config.xScale, tile.row * config.yScale
    heading = config.origin.heading
    _pose_to(config.origin, made.info.origin)
    position = made.info.origin.position
    position.x += along * math.cos(heading) - across * math.sin(heading)
    position.y += along * math.sin(heading) + across * math.cos(heading)
    made.data = [cell if cell <= _OCCUPIED else -1 for cell in tile.cells]


def map_of_grid(sample: Any, made: Any) -> None:
    """Convert nav_msgs/msg/OccupancyGrid to OccupancyGridMap: one tile. Unknown cells are 255."""
    info, config, tile = sample.info, made.config, made.map
    time_of_stamp(sample.header.stamp, made.tm)
    config.xScale = config.yScale = info.resolution
    config.width, config.height = tile.width, tile.height = info.width, info.height
    config.origin.position.x = info.origin.position.x
    config.origin.position.y = info.origin.position.y
    config.origin.heading = heading_of(info.origin.orientation)
    tile.column = tile.row = 0
    tile.cells = bytes(
        cell if 0 <= cell <= _OCCUPIED else _UNKNOWN for cell in sample.data
    )
