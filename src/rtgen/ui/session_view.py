"""What the parts of a session use of it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

from rtgen import runtime
from rtgen.compiler.model import System, SystemComponent
from rtgen.runtime.system.joining import Connector
from rtgen.ui.buses import Buses
from rtgen.ui.channels import Channels
from rtgen.ui.compared_run import Comparison
from rtgen.ui.description import Description
from rtgen.ui.edits import Edits
from rtgen.ui.flows import Chains, Flows
from rtgen.ui.history import History
from rtgen.ui.pages import Pages
from rtgen.ui.project_systems import CommandProject
from rtgen.ui.protocol import ui
from rtgen.ui.remote_state import RemoteState
from rtgen.ui.runner import Runner
from rtgen.ui.type_table import TypeTable


class SessionView(Protocol):
    """The session, as its parts know it."""

    buses: Buses
    beside: Comparison
    channels: Channels
    describe: Description
    edits: Edits
    flows: Flows
    chains: Chains
    foreign: Mapping[str, SystemComponent]
    places: dict[str, tuple[float, float]]
    history: History
    pages: Pages
    palette: list[ui.PaletteEntry]
    profile: System
    project: CommandProject
    types: TypeTable
    runner: Runner

    @property
    def connectors(self) -> list[Connector]: ...

    @property
    def now(self) -> float: ...

    @property
    def remote(self) -> RemoteState: ...

    @property
    def system(self) -> runtime.System: ...

    def component(self, instance: str) -> ui.Component: ...

    def edit_state(self) -> ui.EditState: ...

    def forget(self, instance: str) -> None: ...

    def is_within(self, connector: Connector) -> bool: ...

    def notice(self, kind: str, instance: str, text: str) -> None: ...

    def publish(self, *events: ui.Event) -> None: ...

    def run_again(self) -> None: ...

    def sample(self, sample: ui.Sample) -> None: ...

    def time(self) -> ui.ClockState: ...

    def whole(self) -> ui.SystemState: ...

    def watch_changed(self) -> None: ...
