"""Interface through which a session accesses its project; implemented by the command line."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple, Protocol

from rtgen import runtime
from rtgen.compiler.diagnostics import Diagnostic
from rtgen.compiler.model import PortReference, System, SystemComponent
from rtgen.compiler.systems.timeline import Timeline
from rtgen.runtime.failures import Failure
from rtgen.runtime.marshalling.descriptors import DataType
from rtgen.runtime.rtc.profiles import ComponentProfile
from rtgen.runtime.services.servants import Servant
from rtgen.ui.buses import Describer
from rtgen.ui.documents.document import Document

if TYPE_CHECKING:
    from rtgen.runtime.opaque_rpc.codecs import Codec
    from rtgen.tools.renaming.plan import Renaming


class Opened(NamedTuple):
    """A system and its file; `document` is None without one."""

    profile: System
    document: Document | None


class Known(NamedTuple):
    """The name of a file, and the content that the session knows; None: there is no file."""

    file: str
    data: bytes | None


class RunWatcher(NamedTuple):
    """Functions that are called for failures of components, and events of the timeline.

    These are skipped, or they are calls of an instance, with their outcome.
    """

    failed: Callable[[Failure], None]
    skipped: Callable[[Diagnostic], None]
    called: Callable[[str, str], None]


class Project(Protocol):
    """The systems of a project, and how they are created."""

    @property
    def systems(self) -> Sequence[str]:
        """The files that can be opened."""

    @property
    def recordings(self) -> Sequence[str]:
        """The recordings that can be compared with a run, the latest first."""

    def recording(self, name: str) -> str:
        """Return the file of a recording of the project. Raises CommandError."""

    def read(self, file: str) -> Opened:
        """Read the system of a file. Raises InputError."""

    def write(self, file: str, data: bytes, own: Known, *, replace: bool) -> str:
        """Write a system's file, which must not leave the project.

        `own` is the file of the session. Other content than that is only replaced if `replace`;
        then it is kept in another file, whose name is returned, else an empty text. Raises
        CommandError, with QUESTION if the user must decide.
        """

    def timeline(self, profile: System) -> Timeline:
        """Return the timeline of a system of `read`."""

    def renaming(self, old: str, new: str) -> Renaming:
        """Plan a rename of what a definition names. Raises InputError."""

    def renaming_of_instance(self, file: str, instance: str, name: str) -> Renaming:
        """Plan a rename of a component of a system's file. Raises InputError."""

    def rename(self, renaming: Renaming) -> None:
        """Change the files of a rename, and those generated from them; systems are read anew.

        Raises InputError, ToolError.
        """

    def refusals(self, profile: System) -> Sequence[str]:
        """Return why `rtgen run` would not start to run a system of `read` with changes."""

    def judged(
        self,
        source: PortReference,
        target: PortReference,
        types: Mapping[str, str],
        properties: Mapping[str, str],
    ) -> Sequence[Diagnostic]:
        """Return warnings and errors about joining two ports, by the definitions of the project.

        `types` has the types of the two instances.
        """

    def assemble(
        self, profile: System, clock: runtime.Clock, watcher: RunWatcher
    ) -> runtime.System:
        """Create a system, INACTIVE, with its timeline. Raises InputError or ToolError."""

    def report_end(self, reason: str) -> None:
        """Report why a run has ended to the person at the terminal."""

    def add(
        self, system: runtime.System, component: SystemComponent, folder: Path
    ) -> None:
        """Add a component to a running system, whose file is in a folder.

        Raises InputError, ToolError.
        """

    def record(self, system: runtime.System) -> Callable[[], None]:
        """Record a system from now on, if runs are recorded; return a function that ends it."""

    def data_type(self, name: str) -> type[DataType] | None:
        """Return a type of samples by its scoped name or the last part of that; None if unknown."""

    def interface(self, name: str) -> type[Servant] | None:
        """Return an interface by its scoped name or the last part of that; None if unknown."""

    def codec(self, type_: str) -> Codec | None:
        """Return the codec of a marshaller type; None for another type."""

    def palette(self) -> Sequence[ComponentProfile]:
        """Return the component types of which pages can add instances."""

    def describer(self, bus: str, network: str) -> Describer:
        """Return the description of a CAN bus, by the names of its channel and its network."""
