"""What a session needs of the project around it, which the command line gives it."""

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
    """Systems of a project and how they are made."""

    @property
    def systems(self) -> Sequence[str]:
        """The files that can be opened."""

    def read(self, file: str) -> System:
        """The system of a file. Raises InputError."""

    def write(self, file: str, text: str) -> None:
        """Write a system's file, which must not leave the project. Raises CommandError."""

    def assemble(
        self, profile: System, clock: runtime.Clock, failed: Callable[[Failure], None]
    ) -> runtime.System:
        """A system, INACTIVE, with its timeline. Raises InputError or ToolError."""

    def add(self, system: runtime.System, component: SystemComponent) -> None:
        """Add a component to a running system. Raises InputError, ToolError."""

    def record(self, system: runtime.System) -> Callable[[], None]:
        """Record a system from now on, if runs are recorded; return a function that ends that."""

    def data_type(self, name: str) -> type[DataType] | None:
        """Return a type of samples by its scoped name or the last part of that; None if unknown."""

    def interface(self, name: str) -> type[Servant] | None:
        """Return an interface by its scoped name or the last part of that; None if unknown."""

    def palette(self) -> Sequence[ComponentProfile]:
        """The types of components of which instances can be added."""

    def describer(self, bus: str, network: str) -> Describer:
        """Return the description of a CAN bus, by the names of its channel and its network."""
