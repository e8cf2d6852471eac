"""The definitions of the reference build: readable by others, and complete."""

from __future__ import annotations

import subprocess
import sys
from math import radians
from pathlib import Path

import pytest

from refrobots import iis
from refrobots.components.ceiling_navigation import CeilingNavigationBase
from refrobots.components.game_pad import GamePadBase
from refrobots.components.localize_center import LocalizeCenterBase
from refrobots.components.lrf_capture_urg import LRFCapture_URGBase
from refrobots.components.navigation import NavigationBase
from refrobots.components.odometry import OdometryBase
from refrobots.components.odometry_rh2 import OdometryRh2Base
from refrobots.components.omni_to2_wd import OmniTo2WDBase
from refrobots.components.path_follower import PathFollowerBase
from refrobots.components.path_planning import PathPlanningBase
from refrobots.components.position_input import PositionInputBase
from refrobots.components.ref_hard_rh2 import RefHardRh2Base
from refrobots.components.ref_hard_rh3 import RefHardRh3Base
from refrobots.components.switch_input_rtc import SwitchInputRTCBase
from rtgen.compiler.project import load
from rtgen.compiler.project.output import component_types
from rtgen.runtime import Component
from rtgen.tools.running.factories import Factories

SPECS = Path(__file__).parents[2] / "specs"
TYPE_FILES = sorted((SPECS / "idl").glob("*.idl"))

POSE = "IIS::TimedPose2D"
VELOCITY = "IIS::TimedVelocity2D"
STATE = "RTC::TimedState"
AXES = ("LX", "LY", "RX", "RY")

# Specification of the RH3 navigation modules 1.10: port tables 3-2 to 3-24.
PORTS = {
    PositionInputBase: {("inport", "status", STATE), ("outport", ".positon", POSE)},
    OmniTo2WDBase: {
        ("inport", "current_position", POSE),
        ("inport", "goal", POSE),
        ("inport", "status", STATE),
        ("outport", "min_path", "IIS::TimedPath2DSeq"),
        ("outport", "status", STATE),
    },
    NavigationBase: {
        ("inport", "position", POSE),
        ("inport", "min_path", "IIS::TimedPath2DSeq"),
        ("outport", "path", "RTC::Path"),
        ("outport", "status", STATE),
    },
    PathFollowerBase: {
        ("inport", "position", POSE),
        ("inport", "target_path", "RTC::Path"),
        ("outport", "velocity", VELOCITY),
    },
    RefHardRh3Base: {
        ("inport", "InTargetVelocity", VELOCITY),
        ("outport", "OutWheelAngle", "RTC::TimedDoubleSeq"),
        ("provider", "InventGUIRefHard", "RefHard"),
        ("provider", "BumpRefHard", "RefHard"),
        # Additions of rtgen: simulated sensors receive the pose of the simulated base.
        ("outport", "PlantPose", POSE),
    },
    OdometryBase: {
        ("inport", "CurrentWheelAngle", "RTC::TimedDoubleSeq"),
        ("inport", "LocalizedPosition", POSE),
        ("outport", "OdometryPosition", POSE),
    },
}

# Public RH2 components.
PORTS |= {
    PathPlanningBase: PORTS[OmniTo2WDBase],
    RefHardRh2Base: PORTS[RefHardRh3Base],
    OdometryRh2Base: PORTS[OdometryBase],
    LocalizeCenterBase: {
        ("inport", "dp_odmIn", POSE),
        ("inport", "dp_ceilIn", POSE),
        ("outport", "dp_out0", POSE),
    },
    CeilingNavigationBase: {
        ("inport", "CameraData", "RTC::TimedOctetSeq"),
        ("inport", "LocalizedPosition", POSE),
        ("outport", "CeilingPosition", POSE),
    },
    SwitchInputRTCBase: {
        ("inport", "inVelJoy", VELOCITY),
        ("inport", "inVelAuto", VELOCITY),
        ("outport", "outVel", VELOCITY),
    },
    GamePadBase: {
        ("outport", "Button", "RTC::TimedULong"),
        *(("outport", f"Stick{axis}", "RTC::TimedFloat") for axis in AXES),
        *(("outport", f"Stick{axis}d", "RTC::TimedDouble") for axis in AXES),
        ("outport", "Velocity", "RTC::TimedVelocity"),
        ("outport", "VelocityIIS", "IIS::TimedVelocity"),
        ("outport", "Velocity2DIIS", VELOCITY),
    },
    LRFCapture_URGBase: {
        ("inport", "pose", POSE),
        ("outport", "range", "RTC::RangeData"),
    },
}

# The same, configuration tables 3-4 to 3-25: default and unit.
PARAMETERS: dict[type[Component], dict[str, tuple[object, str]]] = {
    PositionInputBase: {
        "01_x": (3.4, "m"),
        "01_y": (7.7, "m"),
        "01_th": (-1.57, "rad"),
    },
    OmniTo2WDBase: {},
    NavigationBase: {"judge_radius": (0.5, "m"), "max_vel": (0.3, "m/s")},
    PathFollowerBase: {
        "control_cycle": (0.02, "s"),
        "line_C1": (0.01, ""),
        "line_Dist": (0.05, "m"),
        "line_K1": (800.0, ""),
        "line_K2": (300.0, ""),
        "line_K3": (400.0, ""),
        "max_acc_v": (0.0003, "m/s"),
        "max_acc_w": (0.1, "rad/s"),
        "max_v": (1.0, "m/s"),
        "max_w": (0.3, "rad/s"),
    },
    RefHardRh3Base: {
        "DeviceFileName": ("/dev/ttyUSB0", ""),
        "gain_P": (10, ""),
        "gain_I": (0, ""),
        "gain_D": (0, ""),
        "gain_VP": (10, ""),
        "gain_VI": (0, ""),
        "gain_VD": (1, ""),
        "Velocity_limit": (10.0, "rad/s"),
        "Acceleration_limit": (50.0, "rad/s^2"),
        "WheelTread": (0.441, "m"),
        "WheelRadiusLeft": (0.1, "m"),
        "WheelRadiusRight": (0.1, "m"),
        "GearRatio": (74.91, ""),
        "EncoderCount": (2000, ""),
        "EncoderConstant_L": (1.0, ""),
        "EncoderConstant_R": (1.0, ""),
    },
    OdometryBase: {
        "leftWheelID": (0, ""),
        "rightWheelID": (1, ""),
        "radiusOfLeftWheel": (0.0995, "m"),
        "radiusOfRightWheel": (0.0995, "m"),
        "lengthOfAxle": (0.464, "m"),
        "radiusOfBodyArea": (0.45, "m"),
        "initialPose_x": (0.0, "m"),
        "initialPose_y": (0.0, "m"),
        "initialPose_theta": (0.0, "rad"),
    },
}

PARAMETERS |= {
    PathPlanningBase: {"map_file": ("route_map", "")},
    RefHardRh2Base: {
        name: entry
        for name, entry in PARAMETERS[RefHardRh3Base].items()
        if name != "GearRatio"
    },
    OdometryRh2Base: {
        "leftWheelID": (0, ""),
        "rightWheelID": (1, ""),
        "radiusOfLeftWheel": (0.1, "m"),
        "radiusOfRightWheel": (0.1, "m"),
        "lengthOfAxle": (0.441, "m"),
        "radiusOfBodyArea": (0.45, "m"),
    },
    LocalizeCenterBase: {
        "startX": (3.24, "m"),
        "startY": (7.7, "m"),
        "startTheta": (-1.57, "rad"),
        "cycle": (20, ""),
    },
    CeilingNavigationBase: {
        "NavigationMap": ("ceiling_map", ""),
        "BlockCoefficient": (0.414, ""),
        "SearchScope": (2.0, ""),
        "BlackWhiteValue": (220, ""),
        "Center_X": (160, ""),
        "Center_Y": (120, ""),
        "RealMapSize": (100.0, "cm"),
        "VirtualMapSize": (100.0, "pixels"),
    },
    SwitchInputRTCBase: {},
    GamePadBase: {
        "Klx": (1.0, "m/s"),
        "Kly": (1.0, "m/s"),
        "Krx": (1.0, "rad/s"),
        "Kry": (1.0, ""),
        "str_port": ("/dev/input/js0", ""),
    },
    # Data of the range finder: 4 m, 240 degrees.
    LRFCapture_URGBase: {
        "max_range": (4.0, "m"),
        "angle": (radians(120.0), "rad"),
    },
}

OURS = {
    PositionInputBase: {"input", "input_file"},
    OmniTo2WDBase: {"PositionTimeout", "StatusTimeout", "ArrivalRadius"},
    NavigationBase: {"PositionTimeout", "GoalTolerance", "SettleTime", "MaxJump"}
    | {"ProgressTimeout"},
    PathFollowerBase: {"PositionTimeout", "TargetTimeout"},
    OdometryBase: {"WheelAngleTimeout"},
    OdometryRh2Base: {"WheelAngleTimeout", "LocalizationTimeout"},
    LocalizeCenterBase: {"PositionTimeout", "CeilingTimeout"},
    RefHardRh3Base: {
        "PlantWheelTread",
        "PlantWheelRadiusLeft",
        "PlantWheelRadiusRight",
        "PlantStart_x",
        "PlantStart_y",
        "PlantStart_theta",
        "PlantRoom",
        "PlantRadius",
        "CommandTimeout",
    },
    CeilingNavigationBase: {"ImageWidth", "PositionTimeout", "CameraTimeout"},
    GamePadBase: {"script"},
    LRFCapture_URGBase: {
        *("room", "offset_x", "resolution", "min_range", "noise", "seed"),
    },
}
OURS[PathPlanningBase] = OURS[OmniTo2WDBase]
OURS[RefHardRh2Base] = OURS[RefHardRh3Base] | {"GearRatio"}

RATES = {
    PositionInputBase: 10.0,
    OmniTo2WDBase: 50.0,
    NavigationBase: 50.0,
    PathFollowerBase: 1000.0,
    RefHardRh3Base: 1000.0,
    OdometryBase: 100.0,
    PathPlanningBase: 50.0,
    RefHardRh2Base: 1000.0,
    OdometryRh2Base: 100.0,
    LocalizeCenterBase: 100.0,
    CeilingNavigationBase: 50.0,
    SwitchInputRTCBase: 20.0,
    GamePadBase: 66.0,
    LRFCapture_URGBase: 10.0,
}

BASES = pytest.mark.parametrize(
    "base", list(PORTS), ids=lambda base: base.profile.type_name
)


@pytest.mark.sampled(3)
@pytest.mark.parametrize("file", TYPE_FILES, ids=lambda file: file.name)
def test_any_corba_compiler_reads_the_types(file: Path) -> None:
    omniidl = Path(sys.executable).parent / "omniidl"
    done = subprocess.run(
        [omniidl, "-bdump", file], capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stderr) == (0, "")


@BASES
def test_ports(base: type[Component]) -> None:
    ports = base.profile.ports
    assert {(port.kind, port.name, port.type) for port in ports} == PORTS[base]
    assert len(ports) == len(PORTS[base])
    assert all(port.description for port in ports)


@BASES
def test_parameters(base: type[Component]) -> None:
    found = {parameter.name: parameter for parameter in base.profile.configuration}
    assert set(found) == set(PARAMETERS[base]) | OURS.get(base, set())
    assert all(parameter.description for parameter in found.values())
    for name, (default, unit) in PARAMETERS[base].items():
        assert type(default)(found[name].default) == default, name
        assert found[name].unit == unit, name


@BASES
def test_rates(base: type[Component]) -> None:
    assert base.profile.rate == RATES[base]


def test_the_states_and_travel_modes_count_up_from_zero() -> None:
    states = "FINISH ANGLE_CHECK TURNING TURNING2 GOAL_CHECK SPEED_DOWN STOPPING"
    assert {state.name: state.value for state in iis.State} == {
        name: value for value, name in enumerate(states.split())
    }
    modes = "FREE STOP LINEFOLLOW TO_POINT CIRCLEFOLLOW SPIN VEL WHEEL_VEL"
    assert {mode.name: mode.value for mode in iis.TravelMode} == {
        f"RUN_{name}": value for value, name in enumerate(modes.split())
    }
    assert (iis.PATH_FIRST, iis.PATH_MIDDLE, iis.PATH_LAST) == (100, 101, 102)


def test_the_project_makes_every_component() -> None:
    listed = component_types(SPECS.parent / "generated").factories
    assert len(listed) > 40
    factories = Factories(load(SPECS.parent))
    for name, target in listed.items():
        assert factories.types[name] == target
        assert callable(factories[name])
