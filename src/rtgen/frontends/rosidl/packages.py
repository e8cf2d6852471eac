"""Where the interface files of packages stand.

`FOLDER/PACKAGE/msg/Name.msg`, as in the sources of ROS 2 and below `share` of an installation.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Final

from rtgen.diagnostics import Span
from rtgen.facts.ros import INTERFACE_KINDS
from rtgen.frontends.kit.findings import Findings
from rtgen.frontends.rosidl import rules
from rtgen.frontends.rosidl.syntax import MESSAGE_NAME, PACKAGE_NAME

_DEFAULT_PACKAGE: Final = "interfaces"


def identity(path: Path, findings: Findings, span: Span) -> tuple[str, str, str] | None:
    """Package, kind and name of the interface of a file; None if a name is none of ROS 2.

    A file that stands in no folder of its kind is of the package `interfaces`.
    """
    kind = INTERFACE_KINDS[path.suffix.lower()]
    folder = path.absolute().parent
    package = folder.parent.name if folder.name == kind else _DEFAULT_PACKAGE
    name = path.stem
    if not MESSAGE_NAME.fullmatch(name):
        message = f"{name} is no name of an interface"
        hint = "letters and digits, a capital first"
        findings.add(rules.BAD_NAME, span, message, hint=hint)
        return None
    if not PACKAGE_NAME.fullmatch(package):
        message = f"{package} is no name of a package"
        hint = (
            f"the file stands in PACKAGE/{kind}/; lower-case letters, digits, single _"
        )
        findings.add(rules.BAD_NAME, span, message, hint=hint)
        return None
    return package, kind, name


def candidates(
    package: str, name: str, beside: Path, include: Sequence[Path]
) -> list[Path]:
    """The paths where the file of a message can be, as seen from a file that names it."""
    folder = beside.parent
    folders = [folder.parent.parent, *include]
    within = Path(package, "msg", f"{name}.msg")
    found = [each / within for each in folders]
    if folder.name not in INTERFACE_KINDS.values():
        found.insert(0, folder / f"{name}.msg")
    return found
