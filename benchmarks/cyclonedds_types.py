"""IIS::TimedPose2D for cyclonedds-python; its annotations must be evaluated, not postponed."""

from dataclasses import dataclass

from cyclonedds.idl import IdlStruct
from cyclonedds.idl.types import float64, int32, sequence, uint32


@dataclass
class Time(IdlStruct, typename="RTC.Time"):
    """RTC::Time."""

    sec: uint32
    nsec: uint32


@dataclass
class Point2D(IdlStruct, typename="RTC.Point2D"):
    """RTC::Point2D."""

    x: float64
    y: float64


@dataclass
class Pose2D(IdlStruct, typename="RTC.Pose2D"):
    """RTC::Pose2D."""

    position: Point2D
    heading: float64


@dataclass
class TimedPose2D(IdlStruct, typename="IIS.TimedPose2D"):
    """IIS::TimedPose2D."""

    tm: Time
    id: sequence[int32]
    data: Pose2D
    error: sequence[float64]
