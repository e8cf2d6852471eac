"""Result of a run of the compiler: the artifacts, and what they depend on."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import msgspec

from rtgen.compiler.backends import Artifact, ComponentTypes, Emission
from rtgen.compiler.diagnostics import Diagnostic, has_errors, in_order

if TYPE_CHECKING:
    from rtgen.compiler.frontends import FrontendResult


class Compilation(msgspec.Struct, frozen=True):
    """The result of a run: artifacts (none if there are errors), and their inputs.

    `inputs` maps the key of each file read to its sha256; `dependencies` maps the path of each file
    searched for to its sha256, or to None if it was missing. `sources` are the texts of the files
    in diagnostics, by displayed path. `components` are the component types of the project.
    """

    artifacts: Sequence[Artifact]
    inputs: Mapping[str, str]
    diagnostics: tuple[Diagnostic, ...] = ()
    dependencies: Mapping[str, str | None] = msgspec.field(default_factory=dict)
    sources: Mapping[str, str] = msgspec.field(default_factory=dict)
    components: ComponentTypes = ComponentTypes()

    @property
    def failed(self) -> bool:
        """Whether the input has errors."""
        return has_errors(self.diagnostics)


def compilation_of(result: FrontendResult, emission: Emission) -> Compilation:
    """Return the result of a run from what its front ends and back ends returned."""
    model = result.model
    diagnostics = tuple(in_order([*result.diagnostics, *emission.diagnostics]))
    return Compilation(
        artifacts=() if has_errors(diagnostics) else tuple(emission.artifacts),
        inputs={file.key: file.sha256 for file in model.files}
        | {device.key: device.sha256 for device in model.devices}
        | {bus.key: bus.sha256 for bus in model.buses}
        | {system.key: system.sha256 for system in model.systems},
        diagnostics=diagnostics,
        dependencies=result.hashes,
        sources=result.sources,
        components=emission.components,
    )
