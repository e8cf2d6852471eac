"""Interface through which a session accesses its project; implemented by the command line."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Protocol

from rtgen import runtime
from rtgen.model import System, SystemComponent
from rtgen.runtime.failures import Failure
from rtgen.runtime.marshalling.descriptors import DataType
from rtgen.runtime.rtc.profiles import ComponentProfile
from rtgen.runtime.services.servants import Servant
from rtgen.ui.buses import Describer


class Project(Protocol):
    """The systems of a project, and how they are created."""

    @property
    def systems(self) -> Sequence[str]:
        """The files that can be opened."""

    def read(self, file: str) -> System:
        """Read the system of a file. Raises InputError."""

    def write(self, file: str, text: str) -> None:
        """Write a system's file, which must not leave the project. Raises CommandError."""

    def assemble(
        self, profile: System, clock: runtime.Clock, failed: Callable[[Failure], None]
    ) -> runtime.System:
        """Create a system, INACTIVE, with its timeline. Raises InputError or ToolError."""

    def add(self, system: runtime.System, component: SystemComponent) -> None:
        """Add a component to a running system. Raises InputError, ToolError."""

    def record(self, system: runtime.System) -> Callable[[], None]:
        """Record a system from now on, if runs are recorded; return a function that ends it."""

    def data_type(self, name: str) -> type[DataType] | None:
        """Return a type of samples by its scoped name or the last part of that; None if unknown."""

    def interface(self, name: str) -> type[Servant] | None:
        """Return an interface by its scoped name or the last part of that; None if unknown."""

    def palette(self) -> Sequence[ComponentProfile]:
        """Return the component types of which pages can add instances."""

    def describer(self, bus: str, network: str) -> Describer:
        """Return the description of a CAN bus, by the names of its channel and its network."""
