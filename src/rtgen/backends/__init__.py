"""Interface of back ends: pure functions from a model to artifacts, built in or plug-ins."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from enum import StrEnum
from importlib import import_module
from typing import TYPE_CHECKING, Any, Protocol

import msgspec
from msgspec.structs import replace

from rtgen.diagnostics import Diagnostic

if TYPE_CHECKING:  # the cache reuses artifacts without a model
    from rtgen.model import Model, Package


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
    `appendable`, `mutable`) the default for structs and unions without an annotation. `external`
    maps the displayed path of a file to the Python package with its declarations, if that is not
    the generated package. `factories` has `module:name` of the factories of component types set by
    the project; `skeleton_path` is the path from the output folder to the one from which skeletons
    are imported. `small` is the capacity of unbounded sequences and strings, and of InPorts, on the
    target small. `marshalled`: whether calls of interfaces, and sequences by themselves, have
    codecs; `tecs_corba`: whether those of TECS boards also have them without OpenRTM. `lazy`:
    packages import their modules on demand. `ros_interfaces`: also write ROS 2 interface files.
    `plugins` has the table `[plugin.NAME]` of rtgen.toml for each name.
    """

    package: str
    skeleton_package: str
    version: str
    target: str = "embedded"
    representation: str = "cdr"
    extensibility: str = "final"
    external: Mapping[str, str] = msgspec.field(default_factory=dict)
    factories: Mapping[str, str] = msgspec.field(default_factory=dict)
    skeleton_path: str = "../src"
    small: tuple[int, int, int] = (1024, 128, 2)
    marshalled: bool = True
    tecs_corba: bool = False
    lazy: bool = False
    ros_interfaces: bool = False
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
            external=package.types,
        )

    @property
    def corba(self) -> bool:
        """Whether services of TECS boards can be called over CORBA."""
        return self.tecs_corba or self.target == "openrtm"

    @property
    def skeleton_prefix(self) -> str:
        """The prefix of a skeleton's module name."""
        return f"{self.skeleton_package}." if self.skeleton_package else ""


class Part(msgspec.Struct, frozen=True):
    """A generated Python package: the project's own, or one below it.

    `model` has everything that its declarations use, `own` what the package itself contains.
    `origin` are the keys of the inputs of a package below; None for the project's own, whose files
    have the origins of their declarations. `profiles` has the paths of profiles in the package's
    folder, by names of components; other profiles are beside their components.
    """

    model: Model
    own: Model
    options: Options
    origin: tuple[str, ...] | None = None
    profiles: Mapping[str, str] = msgspec.field(default_factory=dict)


def parts(model: Model, options: Options) -> Iterator[Part]:
    """Yield the project's own package, and those that lowerings add below it."""
    yield Part(model, model, options)
    for package in model.packages:
        origin = tuple(source.key for source in package.sources)
        inside = options.inside(package)
        yield Part(package.model, package.own, inside, origin, package.profiles)


class Emission(msgspec.Struct, frozen=True):
    """Result of a back end: artifacts and diagnostics."""

    artifacts: Sequence[Artifact] = ()
    diagnostics: Sequence[Diagnostic] = ()


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
