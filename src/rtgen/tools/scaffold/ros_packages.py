"""Packages of a project for colcon: one of interface files for each package of ROS 2, and one that
runs its systems.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import msgspec

from rtgen.compiler.diagnostics import Diagnostic, InputError, Severity
from rtgen.compiler.model import Model, System
from rtgen.compiler.project import (
    FILE_NAME,
    Project,
    load_run_table,
    output,
    shown,
)
from rtgen.compiler.project.changed_inputs import LIBRARY
from rtgen.compiler.systems.reading import read_file
from rtgen.compiler.typemap.python.names import module_name
from rtgen.facts import ros_names
from rtgen.facts.idl_files import IDL_SUFFIXES
from rtgen.facts.ros import INTERFACE_SUFFIXES, is_interface
from rtgen.ros2.backend.backend import FOLDER as GENERATED
from rtgen.ros2.backend.packages import InterfaceText, interface_texts
from rtgen.tools.running import ros2_boards
from rtgen.tools.running.plan import nothing
from rtgen.tools.scaffold.names import ros_package_name
from rtgen.tools.scaffold.package_facts import Facts, package_facts
from rtgen.tools.scaffold.rules import CIRCLE, NO_SYSTEM, OUTSIDE
from rtgen.tools.scaffold.starters import File, Link, rendered

_RUNNING = (
    *("ament_index_python", "launch", "launch_ros", "lifecycle_msgs", "rclpy"),
    "ros2launch",
)
"""What the package with the systems needs to run."""
_ALONE = "boards"
"""The program that runs the boards of a project without a system."""


class LaunchedSystem(msgspec.Struct, frozen=True):
    """A system: name of its program, path below the project, and managed nodes in their order."""

    name: str
    path: str
    nodes: tuple[str, ...]


class Packages(msgspec.Struct, frozen=True):
    """The files of all packages, the names of the packages, those of packages that exist already,
    warnings about what is left out, and what `package.xml` has placeholders for.
    """

    files: Sequence[File | Link]
    names: Sequence[str]
    existing: Sequence[str]
    findings: Sequence[Diagnostic]
    missing: str


def packages(
    name: str,
    project: Project,
    model: Model,
    systems: Sequence[Path],
    folder: Path,
) -> Packages:
    """Return the packages of a project, below `folder`; `name` is that of the systems' package.

    `systems` are launched, by default those of the project, else that of `[run]`, else its boards
    alone. Packages of
    interfaces that exist are left as they are. Raises InputError for a name that ROS 2 does not
    allow, for packages that need each other, without a system, and for files outside of the
    project's folder; ToolError for a `pyproject.toml` that is not TOML.
    """
    texts, findings = interface_texts(model)
    by_package = _own_packages([*texts, *_of_boards(project, model)])
    keys = {file.name: file.key for file in model.files}
    findings = [d for d in findings if d.span is None or _is_own(keys[d.span.file])]
    _require_order(by_package)
    written = {
        package: files
        for package, files in by_package.items()
        if not _has_manifest(project, package, files)
        and not (folder / package).exists()
    }
    needed = {d.name[0] for d in model.declarations if is_interface(d.name)}
    taken = {*needed, *by_package, *_RUNNING, project.package.partition(".")[0]}
    ros_package_name(name, taken | {project.skeleton_package})
    facts = package_facts(project)
    files: list[File | Link] = []
    for package, own in written.items():
        files += _interfaces(project, package, own, folder / package, facts)
    launched = _launched(project, systems)
    needed = {*needed, *by_package, *_RUNNING}
    files += _systems(name, project, launched, needed, folder / name, facts)
    missing = " and no ".join(facts.missing)
    existing = [package for package in by_package if package not in written]
    return Packages(files, [*written, name], existing, findings, missing)


def _is_own(key: str) -> bool:
    """Return whether a file declares types of the project: not a library, nor a description of a
    device.
    """
    is_definition = key.endswith((*IDL_SUFFIXES, *INTERFACE_SUFFIXES))
    return not key or (is_definition and not key.startswith(LIBRARY))


def _own_packages(
    texts: Iterable[InterfaceText],
) -> dict[str, list[InterfaceText]]:
    """Return the files of the project's packages, and of those that they need."""
    packages: dict[str, list[InterfaceText]] = {}
    for each in texts:
        packages.setdefault(each.package, []).append(each)
    own: set[str] = set()
    waiting = {each.package for each in texts if _is_own(each.key)}
    while waiting:
        own |= waiting
        needed = {
            p for name in waiting for each in packages[name] for p in each.packages
        }
        waiting = (needed & packages.keys()) - own
    return {name: files for name, files in packages.items() if name in own}


def _of_boards(project: Project, model: Model) -> Iterator[InterfaceText]:
    """Yield the interface files of TECS boards."""
    if not (project.ros2.boards and model.packages):
        return
    from rtgen.ros2.boards.interfaces import interfaces

    for made in interfaces(model, project.package):
        for path, text in made.texts.items():
            needs = frozenset({"service_msgs"} if path.endswith(".srv") else ())
            yield InterfaceText(path=path, text=text, file="", key="", packages=needs)


def _require_order(by_package: Mapping[str, Sequence[InterfaceText]]) -> None:
    """Raise InputError for packages that need each other."""
    needs = {
        package: {p for each in files for p in each.packages} & by_package.keys()
        for package, files in by_package.items()
    }
    remaining = {*needs}
    while free := {
        package
        for package in remaining
        if not needs[package] & remaining
        or all(package not in needs[other] for other in remaining)
    }:
        remaining -= free
    if remaining:
        names = ", ".join(sorted(remaining))
        hint = "declare what both need in a module of its own"
        message = f"packages of ROS 2 that need each other: {names}"
        raise InputError([CIRCLE.at(None, message, hint=hint)])


def _has_manifest(
    project: Project, package: str, files: Iterable[InterfaceText]
) -> bool:
    """Return whether the interface files of a package are in one that colcon builds already."""
    folders = {(project.root / each.key).parents[1] for each in files if each.key}
    return any(f.name == package and (f / "package.xml").is_file() for f in folders)


def _interfaces(
    project: Project,
    name: str,
    texts: Sequence[InterfaceText],
    folder: Path,
    facts: Facts,
) -> Iterator[File | Link]:
    needed = sorted({package for each in texts for package in each.packages})
    values = {
        "name": name,
        "packages": needed,
        "facts": facts,
        "description": f"Interfaces of {facts.name}",
    }
    yield rendered(folder / "package.xml", "ros2/interfaces.xml", **values)
    yield rendered(folder / "CMakeLists.txt", "ros2/interfaces.txt", **values)
    if project.ros2.interfaces or not any(each.key for each in texts):
        for kind in sorted({each.path.split("/")[1] for each in texts}):
            yield _link(folder / kind, project.output / GENERATED / name / kind)
    else:
        for each in texts:
            yield File(folder.parent / each.path, each.text)


def _link(path: Path, target: Path) -> Link:
    relative = os.path.relpath(target, os.path.realpath(path.parent))
    return Link(path, Path(relative))


def _launched(project: Project, systems: Sequence[Path]) -> list[LaunchedSystem]:
    """Return the systems, which have different names. Raises InputError.

    Without a system they are the boards alone.
    """
    boards = ros2_boards.of_project(project)
    launched: dict[str, LaunchedSystem] = {}
    of_run = load_run_table().system
    default = project.systems or ([of_run] if of_run else [])
    for path in systems or default:
        file = path / "system.xml" if path.is_dir() else path
        profile, diagnostics, _ = read_file(file)
        if profile is None:
            raise InputError([d for d in diagnostics if d.severity is Severity.ERROR])
        name = module_name(path.stem if path.stem != "system" else path.parent.name)
        if name in launched:
            message = f"{shown(path)}: {launched[name].path} is called {name}, too"
            raise InputError([NO_SYSTEM.at(None, message, hint="rename one")])
        if boards is not None:
            profile = boards.completed(profile, alone=False)
        launched[name] = _of_profile(project, name, path, profile)
    if not launched and boards is not None:
        profile = boards.completed(nothing(project), alone=True)
        path = project.root / FILE_NAME
        launched[_ALONE] = _of_profile(project, _ALONE, path, profile)
    if not launched:
        message = "neither [sources] paths nor [run] names a system to launch"
        hint = "rtgen new system NAME makes one; --system FILE names one"
        raise InputError([NO_SYSTEM.at(None, message, hint=hint)])
    return [*launched.values()]


def _of_profile(
    project: Project, name: str, path: Path, profile: System
) -> LaunchedSystem:
    order = dict.fromkeys(a.instance for a in profile.activation)
    order |= dict.fromkeys(c.instance for c in profile.components)
    own = _own(project, {c.instance: c.type for c in profile.components})
    nodes = tuple(ros_names.node_name(each) for each in order if each in own)
    managed = nodes if project.ros2.managed_nodes else ()
    return LaunchedSystem(name, _below(project, path), managed)


def _own(project: Project, types: Mapping[str, str]) -> set[str]:
    """Return the instances that rtgen runs, not a program in another language."""
    foreign = output.component_types(project.output).languages
    own = dict(project.components)
    return {name for name, of in types.items() if of in own or of not in foreign}


def _below(project: Project, path: Path) -> str:
    """Return a path below the project's folder. Raises InputError."""
    absolute = Path(os.path.normpath(path.absolute()))
    if not absolute.is_relative_to(project.root):
        message = f"{shown(path)} is outside of the project, so no package has it"
        hint = f"move it below the folder of {FILE_NAME}"
        raise InputError([OUTSIDE.at(None, message, hint=hint)])
    return absolute.relative_to(project.root).as_posix()


def _systems(
    name: str,
    project: Project,
    systems: Sequence[LaunchedSystem],
    needed: Iterable[str],
    folder: Path,
    facts: Facts,
) -> Iterator[File | Link]:
    values: dict[str, Any] = {
        "name": name,
        "facts": facts,
        "description": facts.description,
        "systems": systems,
        "packages": sorted(needed),
        "namespace": project.ros2.namespace,
    }
    for place, template in {
        "package.xml": "package.xml",
        "setup.py": "setup.py",
        "setup.cfg": "setup.cfg",
        f"{name}/__init__.py": "package.py",
        f"{name}/systems.py": "systems.py",
    }.items():
        yield rendered(folder / place, f"ros2/{template}", **values)
    yield File(folder / "resource" / name, "")
    for system in systems:
        launch = folder / "launch" / f"{system.name}.launch.py"
        yield rendered(launch, "ros2/launch.py", **values, system=system)
    for part in _parts(project, systems, folder):
        yield _link(folder / "project" / part, project.root / part)


def _parts(
    project: Project, systems: Sequence[LaunchedSystem], folder: Path
) -> list[str]:
    """Return what a run reads, below the project's folder: files, and whole folders."""
    from rtgen.compiler.project import file as project_file

    assert project.file is not None
    root = project.root
    settings = project_file.read(project.file, FILE_NAME)
    included = settings.texts("sources", "include")
    behaviours = project.import_folders[1]
    named: list[str | Path] = [
        *settings.texts("sources", "paths"),
        *(path for path in included if not Path(path).is_absolute()),
        settings.text("templates", "path", ""),
        project.ros2.zenoh or "",
        project.skeletons if behaviours == root else behaviours,
    ]
    wanted = {_below(project, root / path) for path in named if path}
    wanted = {path for path in wanted if (root / path).exists()}
    wanted |= {FILE_NAME, _below(project, project.output)}
    for system in systems:
        beside = _beside(root / system.path)
        wanted |= {_below(project, each) for each in beside if each.exists()}
    inside = os.path.relpath(folder, root)
    if any(_is_in(inside, path) for path in wanted):
        message = f"{shown(folder)} would be among the files of the project"
        hint = "--folder names another one, such as the src of a workspace"
        raise InputError([OUTSIDE.at(None, message, hint=hint)])
    return sorted(
        path
        for path in wanted
        if not any(_is_in(path, other) for other in wanted - {path})
    )


def _beside(system: Path) -> Iterator[Path]:
    """Yield a system, and the files beside it that it can name."""
    yield system
    yield from system.parent.glob("*.conf")


def _is_in(path: str, folder: str) -> bool:
    return folder == "." or path == folder or path.startswith(f"{folder}/")
