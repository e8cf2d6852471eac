"""Files that ship with rtgen, in the installed package or beside the source tree."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from typing import Any

_PACKAGE = Path(__file__).resolve().parents[2]
_FOLDERS = (_PACKAGE / "grammars", _PACKAGE.parents[1] / "grammars")

OPENRTM_IDL = (
    *("BasicDataType.idl", "ExtendedDataTypes.idl", "InterfaceDataTypes.idl"),
)
"""OpenRTM's data types; each file comes after those that it includes."""

IDL_FILES = (*OPENRTM_IDL, "Canopen.idl", "CanopenManager.idl")
"""The IDL files that definitions may include without having a copy."""

_IDL = (Path(__file__).parent / "idl", _PACKAGE.parents[1] / "specs" / "idl")

_USUAL_UNITS = Path(__file__).parent / "usual_units.json"

_ROS = _PACKAGE / "ros2" / "interfaces"

_NAVIGATION = ("Navigation", "Odometry", "OmniTo2WD", "PathFollower", "PositionInput")
_BEHAVIOURS = """
    __init__ base_control commands console geometry kinematics limiter line_following map_text
    messages navigation newest odometry omni_to2_wd path_follower planner planning plant
    pose_history position_input rays recent ref_hard_rh3 room simulated_ref_hard
    """
_DEFINITIONS = (
    *(
        f"specs/idl/{name}.idl"
        for name in ("RefHardRh3Pro", "checkpoints", "intellirobot")
    ),
    *(f"specs/navigation/{name}.idl" for name in (*_NAVIGATION, "RefHardRh3")),
    *("specs/navigation/ref_hard.inc", "specs/navigation/rh3_path.txt"),
    *("specs/navigation/rh3_goal.xml", "specs/navigation/rh3_path.xml"),
)
RH3_FILES = {
    **{name: name for name in _DEFINITIONS},
    **{
        f"src/refnav/{name}.py": f"reference/refnav/{name}.py"
        for name in _BEHAVIOURS.split()
    },
}
"""The files of the reference pipeline, which `rtgen new project --from rh3` copies.

Each has the path in this repository that it comes from.
"""

RH3_FOLDER = "examples/rh3"
"""The folder of these files in the package."""


def rh3_source(name: str) -> str:
    """Return the text of one of RH3_FILES. Raises FileNotFoundError."""
    packed = _PACKAGE / RH3_FOLDER / name
    source = packed if packed.is_file() else _PACKAGE.parents[1] / RH3_FILES[name]
    return _path(source.name, (source.parent,)).read_text("utf-8")


def grammar_file(name: str) -> Path:
    """Return the path of a grammar (`idl.lark`). Raises FileNotFoundError."""
    return _path(name, _FOLDERS)


def idl_file(name: str) -> Path:
    """Return the path of an IDL file that ships with rtgen (`Canopen.idl`). Raises
    FileNotFoundError.
    """
    return _path(name, _IDL)


def idl_source(name: str) -> str:
    """Return the text of an IDL file that ships with rtgen. Raises FileNotFoundError."""
    return idl_file(name).read_text("utf-8")


def idl_key(name: str) -> str:
    """Return the key of an IDL file that ships with rtgen, its name in generated text."""
    return f"rtgen/idl/{name}"


@cache
def implemented_idl() -> dict[str, str]:
    """Return the keys of the IDL files with types in the runtime, and their digests."""
    digests = json.loads(idl_source("implemented.json"))
    return {idl_key(name): digest for name, digest in digests.items()}


def usual_units() -> dict[str, Any]:
    """Return what pint says about usual units, and its names of units and prefixes."""
    content: dict[str, Any] = json.loads(_USUAL_UNITS.read_text("utf-8"))
    return content


@cache
def ros_interfaces() -> tuple[str, ...]:
    """Return the ROS 2 interface files that ship with rtgen (`std_msgs/msg/Header.msg`), in
    order.
    """
    files = _ROS.glob("*/*/*.*")
    return tuple(sorted(file.relative_to(_ROS).as_posix() for file in files))


def ros_file(name: str) -> Path:
    """Return the path of one of `ros_interfaces`. Raises FileNotFoundError."""
    return _path(name, (_ROS,))


def ros_source(name: str) -> str:
    """Return the text of one of `ros_interfaces`. Raises FileNotFoundError."""
    return ros_file(name).read_text("utf-8")


def _path(name: str, folders: tuple[Path, ...]) -> Path:
    for folder in folders:
        path = folder / name
        if path.is_file():
            return path
    raise FileNotFoundError(f"{name} is missing from this installation")
