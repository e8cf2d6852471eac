"""Result of a run of the compiler: the artifacts, and what they depend on."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import msgspec

from rtgen.backends import Artifact, ComponentTypes
from rtgen.diagnostics import Diagnostic, has_errors


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
