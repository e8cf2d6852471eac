"""Finds the interface files of packages.

`FOLDER/PACKAGE/msg/Name.msg`, as in the sources of ROS 2 and below `share` of an installation. The
common packages ship with rtgen, and are used if no folder contains them.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import cache, partial
from pathlib import Path
from typing import Final

from rtgen.compiler.diagnostics import Span
from rtgen.compiler.frontends import Dependency
from rtgen.compiler.frontends.kit.findings import Findings
from rtgen.compiler.frontends.kit.library import VirtualFile
from rtgen.compiler.kit.resources import ros_file, ros_interfaces, ros_source
from rtgen.compiler.model import ScopedName, SourceFile
from rtgen.facts.ros import INTERFACE_KINDS
from rtgen.ros2.rosidl import rules
from rtgen.ros2.rosidl.syntax import MESSAGE_NAME, PACKAGE_NAME

_DEFAULT_PACKAGE: Final = "interfaces"
_KEYS: Final = "rtgen/rosidl/"
"""Prefix of the keys of files that ship with rtgen."""


def identity(path: Path, findings: Findings, span: Span) -> tuple[str, str, str] | None:
    """Return package, kind and name of a file's interface; None if a name is invalid in ROS 2.

    A file outside of a folder of its kind is in the package `interfaces`.
    """
    folder = path.absolute().parent
    kind = INTERFACE_KINDS.get(path.suffix.lower(), folder.name)
    package = folder.parent.name if folder.name == kind else _DEFAULT_PACKAGE
    name = path.stem
    if not MESSAGE_NAME.fullmatch(name):
        message = f"{name} is not a name of an interface"
        hint = "letters and digits, a capital first"
        findings.add(rules.BAD_NAME, span, message, hint=hint)
        return None
    if not PACKAGE_NAME.fullmatch(package):
        message = f"{package} is not a name of a package"
        hint = (
            f"the file must be in PACKAGE/{kind}/; lower-case letters, digits, single _"
        )
        findings.add(rules.BAD_NAME, span, message, hint=hint)
        return None
    return package, kind, name


def candidates(
    name: ScopedName, beside: Path, include: Sequence[Path]
) -> list[tuple[Path, Path | None]]:
    """Return the paths where the file of a message can be, as seen from a file that uses it.

    Each path comes with its include folder.
    """
    folder = beside.parent
    within = file_of(name)
    places: list[tuple[Path, Path | None]] = [(folder.parent.parent / within, None)]
    if folder.name not in INTERFACE_KINDS.values():
        places.insert(0, (folder / within.rpartition("/")[2], None))
    return [*places, *((each / within, each) for each in include)]


def file_of(name: ScopedName) -> str:
    """Return the file of a message in a folder of packages: `std_msgs/msg/Header.msg`.

    For `std_srvs/srv/SetBool_Request` it is `std_srvs/srv/SetBool.srv`.
    """
    package, kind, message = name
    return f"{package}/{kind}/{message.partition('_')[0]}.{kind}"


@cache
def shipped() -> Mapping[str, VirtualFile | Path]:
    """Return the interface files that ship with rtgen, by name."""
    return {
        name: VirtualFile(f"{_KEYS}{name}", partial(ros_source, name))
        for name in ros_interfaces()
    }


def is_shipped(key: str) -> bool:
    """Return whether a file with a key is one of those that ship with rtgen."""
    return key.startswith(_KEYS)


def dependencies(files: Sequence[SourceFile]) -> Iterator[Dependency]:
    """Yield the dependencies on those of the files that ship with rtgen."""
    for file in files:
        if is_shipped(file.key):
            path = ros_file(file.key.removeprefix(_KEYS))
            yield Dependency(path, file.sha256)
