"""The files of each starter, as paths and texts."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from rtgen.compiler.backends.kit.rendering import render
from rtgen.compiler.backends.profiles.rts_profile import system_text
from rtgen.compiler.diagnostics import InputError
from rtgen.compiler.kit.resources import RH3_FILES, rh3_source
from rtgen.compiler.kit.translation import ENGLISH, language
from rtgen.compiler.model import Model
from rtgen.compiler.project import FILE_NAME, OUTPUT, Project
from rtgen.compiler.typemap.python.names import skeleton_module
from rtgen.tools.scaffold.names import Names, names, require_free
from rtgen.tools.scaffold.rules import NO_PROJECT
from rtgen.tools.scaffold.systems import system_of

VENDOR = "example"
"""Vendor in new components, for the user to replace."""

FIRST = "Scaler"
"""The component of a new project."""

README = "README.md"

_USED_BY_TESTS = ("LifeCycleState", "SimulatedClock", "System", "TimedDouble")
"""Classes that the test of a new component imports beside the component."""


@dataclass(frozen=True, slots=True)
class File:
    """A file to make: path and text."""

    path: Path
    text: str


@dataclass(frozen=True, slots=True)
class Link:
    """A symbolic link to make, and where it leads from its folder."""

    path: Path
    target: Path


@dataclass(frozen=True, slots=True)
class Place:
    """Where the parts of a project are placed: its packages, and the folders of its files."""

    package: str
    behaviours: str
    definitions: Path
    skeletons: Path
    root: Path

    @property
    def values(self) -> Mapping[str, str]:
        """Variables of templates about the project."""
        return {
            "package": self.package,
            "behaviours": self.behaviours,
            "vendor": VENDOR,
        }

    def behaviour_module(self, name: str) -> str:
        """Return the dotted name of the module of a component's behaviour."""
        return skeleton_module(name, self.package, self.behaviours)

    def behaviour_file(self, name: str) -> Path:
        """Return the file of that module."""
        module = self.behaviour_module(name).rpartition(".")[2]
        return self.skeletons / f"{module}.py"


def readme() -> str:
    """Return the template of a README in the language of texts."""
    return README if language() == ENGLISH else f"README.{language()}.md"


def require_project(project: Project) -> None:
    """Raise InputError without a project."""
    if project.file is None:
        message = f"there is no {FILE_NAME} here, or in a folder above"
        hint = "rtgen new project NAME makes one"
        raise InputError([NO_PROJECT.at(None, message, hint=hint)])


def place_of(project: Project) -> Place:
    """Return the place of new parts: the first folder among the project's sources, and `skeletons`.

    Raises InputError without a project, or without such a folder.
    """
    require_project(project)
    assert project.file is not None
    from rtgen.compiler.project import file as project_file

    settings = project_file.read(project.file, FILE_NAME)
    folders = (project.root / p for p in settings.texts("sources", "paths"))
    definitions = next((f for f in folders if f.is_dir()), None)
    if definitions is None:
        message = "[sources] paths names no folder for new definitions"
        hint = 'add one: paths = ["definitions"]'
        raise InputError([NO_PROJECT.at(None, message, hint=hint)])
    return Place(
        package=project.package,
        behaviours=project.skeleton_package,
        definitions=definitions,
        skeletons=project.skeletons,
        root=project.root,
    )


def component(name: Names, place: Place) -> list[File]:
    """Return a component with a data port each way and a parameter, its behaviour and a test.

    Raises InputError for a name that its test imports.
    """
    require_free(name, _USED_BY_TESTS)
    return files_of(
        "component",
        {
            place.definitions / f"{name.module}.idl": "definition.idl",
            place.behaviour_file(name.module): "behaviour.py",
            _test(place, name): "test.py",
        },
        **place.values,
        name=name.type,
        module=name.module,
        behaviour_module=place.behaviour_module(name.module),
    )


def device(name: Names, place: Place) -> list[File]:
    """Return a CANopen device with a PDO each way, a bus with it, its behaviour and a test."""
    return files_of(
        "device",
        {
            place.definitions / f"{name.module}.eds": "device.eds",
            place.definitions / f"{name.module}_bus.toml": "bus.toml",
            place.behaviour_file(f"{name.module}_device"): "behaviour.py",
            _test(place, name): "test.py",
        },
        **place.values,
        name=name.type,
        module=name.module,
        scope=name.type.lower(),
        behaviour_module=place.behaviour_module(f"{name.module}_device"),
    )


def board(name: Names, place: Place) -> list[File]:
    """Return a TECS board with a signature, a join that leads to it, and a test over TCP."""
    return files_of(
        "board",
        {
            place.definitions / f"{name.module}.cdl": "board.cdl",
            place.definitions / f"{name.module}_types.h": "types.h",
            _test(place, name): "test.py",
        },
        **place.values,
        name=name.type,
        module=name.module,
        macro=name.module.upper(),
        target=f"{name.type}Target",
    )


def system(
    name: Names, place: Place, model: Model, components: Sequence[str]
) -> tuple[list[File], list[str]]:
    """Return a system of components of the project, connected by their types, with a test; and
    what is ambiguous in it.
    """
    profile, ambiguous = system_of(name.module, model, components)
    folder = place.root / "systems"
    test = files_of(
        "system",
        {_test(place, name): "test.py"},
        name=name.module,
        depth=1,
        instances=[c.instance for c in profile.components],
    )
    return [File(folder / f"{name.module}.xml", system_text(profile)), *test], ambiguous


def project(name: Names, package: str, root: Path) -> list[File]:
    """Return a project with a component, but without a system."""
    place = new_place(package, root)
    files = files_of(
        "project",
        {
            root / "pyproject.toml": "pyproject.toml",
            root / README: readme(),
            root / ".gitignore": "gitignore.txt",
            root / ".gitattributes": "gitattributes.txt",
        },
        **place.values,
        generated=OUTPUT,
        name=name.given,
        system=name.module,
    )
    settings = project_settings(name, place, complete=False)
    return [*files, settings, *component(names(FIRST), place)]


def project_settings(name: Names, place: Place, *, complete: bool) -> File:
    """Return the rtgen.toml of a project; `complete`: with the run of its system."""
    files = {place.root / FILE_NAME: "rtgen.toml"}
    values = {"name": name.given, "system": name.module, "complete": complete}
    [file] = files_of("project", files, **place.values, **values)
    return file


def new_place(package: str, root: Path) -> Place:
    """Return the places of the parts of a new project."""
    behaviours = f"{package.replace('.', '_')}_behaviours"
    return Place(
        package=package,
        behaviours=behaviours,
        definitions=root / "definitions",
        skeletons=root / "src" / behaviours,
        root=root,
    )


def base_values(name: Names, place: Place, stamped: bool) -> dict[str, object]:
    """Return the variables of all templates of a base; `stamped`: it takes a TwistStamped."""
    return {
        **place.values,
        "name": name.type,
        "module": name.module,
        "stamped": stamped,
        "twist": "TwistStamped" if stamped else "Twist",
        "is_board": False,
    }


def reference(root: Path) -> list[File]:
    """Return the reference pipeline as a project: the mobile base RH3 drives to a goal."""
    values = {"name": "rh3", "package": "refrobots", "behaviours": "refnav"}
    files = files_of(
        "project",
        {
            root / "pyproject.toml": "pyproject.toml",
            root / ".gitignore": "gitignore.txt",
            root / ".gitattributes": "gitattributes.txt",
        },
        **values,
        generated=OUTPUT,
    )
    files += files_of(
        "reference",
        {
            root / FILE_NAME: "rtgen.toml",
            root / README: readme(),
            root / "tests" / "test_rh3.py": "test.py",
        },
        **values,
    )
    copied = [File(root / name, rh3_source(name)) for name in RH3_FILES]
    return [*files, *copied]


def backend(name: Names, root: Path) -> list[File]:
    """Return a package with a back end, its test, and a project to try it with."""
    package = root / "src" / name.module
    attributes = {root / ".gitattributes": "gitattributes.txt"}
    files = files_of("project", attributes, generated=f"example/{OUTPUT}")
    return files + files_of(
        "backend",
        {
            root / "pyproject.toml": "pyproject.toml",
            root / README: readme(),
            package / "__init__.py": "package.py",
            package / "backend.py": "backend.py",
            root / "tests" / "test_backend.py": "test.py",
            root / "example" / FILE_NAME: "rtgen.toml",
            root / "example" / "parts.idl": "parts.idl",
        },
        name=name.given,
        package=name.module,
    )


def _test(place: Place, name: Names) -> Path:
    return place.root / "tests" / f"test_{name.module}.py"


def files_of(kind: str, templates: Mapping[Path, str], **values: object) -> list[File]:
    """Return files by the templates of a kind of starter."""
    return [rendered(path, f"{kind}/{t}", **values) for path, t in templates.items()]


def rendered(path: Path, template: str, **values: object) -> File:
    """Return a file that a template below `new` describes."""
    return File(Path(os.path.normpath(path)), render(f"new/{template}.j2", **values))
