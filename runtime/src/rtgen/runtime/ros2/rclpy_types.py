"""Classes of the interfaces in an installation of ROS 2, if they are those that rtgen knows."""

from __future__ import annotations

import importlib
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any, Final

import msgspec

from rtgen.facts.files import UnreadableError, is_file, read_file
from rtgen.facts.messages import from_json
from rtgen.runtime.distribution.medium import MediumError
from rtgen.runtime.failures import log

_OF_ACTIONS: Final = {
    "SendGoal": "SendGoalService",
    "GetResult": "GetResultService",
    "FeedbackMessage": "FeedbackMessage",
}
"""Attributes of an action's `Impl` by suffixes; others are attributes of its class."""


class _TypeHash(msgspec.Struct):
    type_name: str
    hash_string: str


class _Described(msgspec.Struct):
    """The file of an interface, `share/PACKAGE/msg/NAME.json` (rosidl, type description)."""

    type_hashes: list[_TypeHash]


def installed(name: str, type_hash: str) -> Any:
    """Return the class of a message or service (`std_msgs/msg/Float32`).

    Raises MediumError if it is not installed, or has another hash than `type_hash`.
    """
    class_, hashes = _described(name)
    other = hashes.get(name)
    if other is None:
        log.warning("%s is installed without its hash, which is not compared", name)
    elif other != type_hash:
        raise MediumError(
            f"{name} is not the one that is installed: its hash is {type_hash}, that of the "
            f"installation {other}; take the installed interface files, [sources] include = "
            "[THE INSTALLATION'S share] in rtgen.toml, or build the package from yours"
        )
    return class_


@cache
def _described(name: str) -> tuple[Any, Mapping[str, str]]:
    """Return the class of an interface and the hashes that its file states, by names."""
    package, kind, last = name.split("/")
    stem, *parts = last.split("_")
    try:
        module = importlib.import_module(f"{package}.{kind}")
    except ModuleNotFoundError as error:
        if error.name not in (package, f"{package}.{kind}"):
            raise MediumError(f"{name} cannot be imported: {error}") from error
        what = f"{stem} of the package" if error.name != package else "the package"
        raise MediumError(_missing(name, f"{what} {package}")) from None
    except ImportError as error:
        raise MediumError(f"{name} cannot be imported: {error}") from error
    class_ = getattr(module, stem, None)
    if class_ is None:
        raise MediumError(_missing(name, f"{stem} of the package {package}"))
    for part in parts:
        hidden = _OF_ACTIONS.get(part)
        class_ = (
            getattr(class_, part) if hidden is None else getattr(class_.Impl, hidden)
        )
    return class_, _hashes(Path(str(module.__file__)), f"{package}/{kind}/{stem}.json")


def _missing(name: str, what: str) -> str:
    package = name.partition("/")[0]
    return (
        f"{name}: {what} is not installed in this ROS 2; build it with colcon and source its "
        f"setup file (rtgen new ros2-package makes {package} of the project's own types), or use "
        "--ros2 dds, which needs no installed packages"
    )


def _hashes(module: Path, place: str) -> dict[str, str]:
    """Return the hashes in an interface's file below the `share` folder beside a module."""
    for folder in module.parents:
        file = folder / "share" / place
        if is_file(file):
            try:
                described = from_json(read_file(file), _Described)
            except (UnreadableError, ValueError) as error:
                raise MediumError(f"{file} cannot be read: {error}") from error
            return {each.type_name: each.hash_string for each in described.type_hashes}
    return {}
