"""Interface of back ends: pure functions from a model to artifacts, built in or plug-ins."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from enum import StrEnum
from importlib import import_module
from typing import TYPE_CHECKING, Any, Protocol

import msgspec
from msgspec.structs import replace

from rtgen.compiler.diagnostics import Diagnostic

if TYPE_CHECKING:  # the cache reuses artifacts without a model
    from rtgen.compiler.model import Declaration, Model, Package


class Owner(StrEnum):
    """Owner of a file: rtgen overwrites its own files, and creates a user's once."""

    RTGEN = "rtgen"
    USER = "user"


class Artifact(msgspec.Struct, frozen=True):
    """A generated file.

    `path` is relative with `/`: rtgen's below the output folder, a user's below the skeleton
    folder. `origin` are the keys of the inputs it was generated from.
    """

    path: str
    text: str
    origin: tuple[str, ...]
    owner: Owner = Owner.RTGEN


class Options(msgspec.Struct, frozen=True):
    """Options of back ends: the generated Python package, skeletons, representation.

    `representation` (`cdr` or `xcdr2`) is the format of `to_cdr`, `extensibility` (`final`,
    `appendable`, `mutable`) the default for structs and unions without an annotation. `factories`
    has `module:name` of the factories of component types set by the project; `skeleton_path` is the
    path from the output folder to the one from which skeletons are imported. `small` is the
    capacity of unbounded sequences and strings, and of InPorts, on the target small. `marshalled`:
    whether calls of interfaces, and sequences by themselves, have codecs; `tecs_corba`: whether
    those of TECS boards also have them without OpenRTM. `lazy`: packages import their modules on
    demand. `ros_interfaces`: also write ROS 2 interface files; `ros_boards`: also
    those of TECS boards, whose services are in this namespace. `ignore_case_clashes`: names of IDL
    may differ in case only. `plugins` has the table `[plugin.NAME]` of rtgen.toml for each name.
    """

    package: str
    skeleton_package: str
    version: str
    target: str = "embedded"
    representation: str = "cdr"
    extensibility: str = "final"
    factories: Mapping[str, str] = msgspec.field(default_factory=dict)
    skeleton_path: str = "../src"
    small: tuple[int, int, int] = (1024, 128, 2)
    marshalled: bool = True
    tecs_corba: bool = False
    lazy: bool = False
    ros_interfaces: bool = False
    ros_boards: str | None = None
    ignore_case_clashes: bool = False
    plugins: Mapping[str, Mapping[str, Any]] = msgspec.field(default_factory=dict)

    @property
    def folder(self) -> str:
        """The folder of the package, below the output folder."""
        return self.package.replace(".", "/")

    def inside(self, package: Package) -> Options:
        """Return the options for a package below the project's own.

        Its values are only marshalled if sent over CORBA or in an `any`.
        """
        return replace(
            self,
            package=f"{self.package}.{package.name}",
            lazy=True,
            marshalled=self.corba or package.any_values,
        )

    @property
    def corba(self) -> bool:
        """Whether services of TECS boards can be called over CORBA."""
        return self.tecs_corba or self.target == "openrtm"


class Part(msgspec.Struct, frozen=True):
    """A generated Python package: the project's own, or one below it.

    `origin` are the keys of the inputs of a package below; None for the project's own, whose files
    have the origins of their declarations. `profiles` has the paths of profiles in the package's
    folder, by names of components; other profiles are beside their components.
    """

    model: Model
    options: Options
    origin: tuple[str, ...] | None = None
    profiles: Mapping[str, str] = msgspec.field(default_factory=dict)

    @property
    def own(self) -> list[Declaration]:
        """The declarations in the package itself, without those of other packages."""
        elsewhere = {file.name for file in self.model.files if file.package}
        return [d for d in self.model.declarations if d.file not in elsewhere]


def parts(model: Model, options: Options) -> Iterator[Part]:
    """Yield the project's own package, and those that lowerings add below it."""
    yield Part(model, options)
    for package in model.packages:
        origin = tuple(source.key for source in package.sources)
        yield Part(package.model, options.inside(package), origin, package.profiles)


class ComponentTypes(msgspec.Struct, frozen=True):
    """Factories of the components of a project, by the names of their types.

    `factories` has `module:name` for each type, `languages` the language of those whose profiles
    name a language other than Python.
    """

    factories: Mapping[str, str] = msgspec.field(default_factory=dict)
    languages: Mapping[str, str] = msgspec.field(default_factory=dict)

    def joined(self, others: ComponentTypes) -> ComponentTypes:
        """Return these types, and those of `others` with other names."""
        new = {
            name: language
            for name, language in others.languages.items()
            if name not in self.factories
        }
        return ComponentTypes(
            {**others.factories, **self.factories}, {**new, **self.languages}
        )


class Emission(msgspec.Struct, frozen=True):
    """Result of a back end: artifacts, diagnostics, and the component types that it knows."""

    artifacts: Sequence[Artifact] = ()
    diagnostics: Sequence[Diagnostic] = ()
    components: ComponentTypes = ComponentTypes()


class Backend(Protocol):
    """A back end, built in or from an entry point `rtgen.backends`."""

    @property
    def name(self) -> str:
        """The name of the back end in messages."""
        ...

    def emit(self, model: Model, options: Options) -> Emission:
        """Return all files for the model, in a fixed order."""
        ...


class DeferredBackend(msgspec.Struct, frozen=True):
    """A back end in a module with an attribute `BACKEND`, imported when it has output."""

    name: str
    module: str
    needed: Callable[[Model, Options], bool]

    def emit(self, model: Model, options: Options) -> Emission:
        """See `Backend`."""
        if not self.needed(model, options):
            return Emission()
        backend: Backend = import_module(self.module).BACKEND
        return backend.emit(model, options)
