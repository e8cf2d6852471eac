"""Back ends: model to artifacts. Pure functions; the built-in ones and plug-ins alike."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from importlib import import_module
from typing import TYPE_CHECKING, Protocol

from rtgen.diagnostics import Diagnostic

if TYPE_CHECKING:  # a run from the cache makes artifacts without the model
    from rtgen.model import Model


class Owner(StrEnum):
    """Who owns a file: rtgen overwrites its own, and creates a user's once."""

    RTGEN = "rtgen"
    USER = "user"


@dataclass(frozen=True, slots=True)
class Artifact:
    """A file to be made. `path` is relative with `/`: rtgen's below the output folder, a user's
    below the skeleton folder. `origin` are the keys of the inputs it came from."""

    path: str
    text: str
    origin: tuple[str, ...]
    owner: Owner = Owner.RTGEN


@dataclass(frozen=True, slots=True)
class Options:
    """What a back end may know: the Python package to make, where skeletons are imported from.

    `representation` (`cdr` or `xcdr2`) is what `to_cdr` gives, `extensibility` (`final`,
    `appendable`, `mutable`) that of structs and unions, where no annotation says so. `external`
    maps the displayed path of a file to the Python package that holds what it declares, where
    that is not the package to make. `factories` has `module:name` of what makes components of a
    type, where the project says it; `skeleton_path` leads from the output folder to the one that
    makes skeletons importable. `small` is the room that the target small has for items of a
    sequence and octets of a string without bound, and for unread samples of an InPort.
    `marshalled`: whether calls of interfaces, and sequences by themselves, have codecs;
    `tecs_corba`: whether those of TECS boards are to have them without OpenRTM, too.
    `lazy`: packages import their modules when a name is asked for.
    """

    package: str
    skeleton_package: str
    version: str
    target: str = "embedded"
    representation: str = "cdr"
    extensibility: str = "final"
    external: Mapping[str, str] = field(default_factory=dict)
    factories: Mapping[str, str] = field(default_factory=dict)
    skeleton_path: str = "../src"
    small: tuple[int, int, int] = (1024, 128, 2)
    marshalled: bool = True
    tecs_corba: bool = False
    lazy: bool = False

    @property
    def folder(self) -> str:
        """The folder of the package, below the output folder."""
        return self.package.replace(".", "/")

    @property
    def skeleton_prefix(self) -> str:
        """What stands in front of a skeleton's module when it is imported."""
        return f"{self.skeleton_package}." if self.skeleton_package else ""


@dataclass(frozen=True, slots=True)
class Emission:
    """What a back end gives."""

    artifacts: Sequence[Artifact] = ()
    diagnostics: Sequence[Diagnostic] = ()


class Backend(Protocol):
    """The interface of a back end, also of one that an entry point `rtgen.backends` brings."""

    @property
    def name(self) -> str:
        """Its name in messages."""
        ...

    def emit(self, model: Model, options: Options) -> Emission:
        """All files for the model, in a fixed order."""
        ...


@dataclass(frozen=True, slots=True)
class DeferredBackend:
    """A back end whose module, which has `BACKEND`, is imported when there is something to emit."""

    name: str
    module: str
    needed: Callable[[Model, Options], bool]

    def emit(self, model: Model, options: Options) -> Emission:
        """See `Backend`."""
        if not self.needed(model, options):
            return Emission()
        backend: Backend = import_module(self.module).BACKEND
        return backend.emit(model, options)
