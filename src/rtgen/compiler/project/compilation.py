"""Result of a run of the compiler: the artifacts, and what they depend on."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

import msgspec

from rtgen.compiler.backends import Artifact, ComponentTypes, Emission
from rtgen.compiler.diagnostics import Diagnostic, Span, has_errors, in_order

if TYPE_CHECKING:
    from rtgen.compiler.frontends import FrontendResult
    from rtgen.compiler.model import Model


class Declared(msgspec.Struct, frozen=True):
    """The place of a declaration in the input `key`; `name` is the last part of its name."""

    key: str
    name: str
    span: Span


class Compilation(msgspec.Struct, frozen=True):
    """The result of a run: artifacts (none if there are errors), and their inputs.

    `inputs` maps the key of each file read to its sha256; `dependencies` maps the path of each file
    searched for to its sha256, or to None if it was missing. `sources` are the texts of the files
    in diagnostics, by displayed path. `components` are the component types of the project,
    `declared` the declarations in its inputs.
    """

    artifacts: Sequence[Artifact]
    inputs: Mapping[str, str]
    diagnostics: tuple[Diagnostic, ...] = ()
    dependencies: Mapping[str, str | None] = msgspec.field(default_factory=dict)
    sources: Mapping[str, str] = msgspec.field(default_factory=dict)
    components: ComponentTypes = ComponentTypes()
    declared: Sequence[Declared] = ()

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
        declared=tuple(dict.fromkeys(_declared(model))),
    )


def _declared(model: Model) -> Iterator[Declared]:
    for part in (model, *(package.model for package in model.packages)):
        keys = {file.name: file.key for file in part.files}
        for each in part.declarations:
            if each.file in keys:
                yield Declared(keys[each.file], each.name[-1], each.span)
