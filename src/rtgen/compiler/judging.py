"""The judge of connections, with the definitions of a project.

`systems.connections` has the judgement. Here are the definitions, read once, and the judgements of
whole systems, which are cached.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING

from msgspec.structs import replace

from rtgen.compiler.diagnostics import Diagnostic, Span
from rtgen.compiler.kit import plugins
from rtgen.compiler.model import Connection, Model, PortReference, System
from rtgen.compiler.project import Project
from rtgen.compiler.project.cache import Cache
from rtgen.compiler.project.compilation import Compilation
from rtgen.compiler.systems.timeline import Connect, Step
from rtgen.facts.encodings import decode
from rtgen.facts.files import MAX_BYTES, read_start

if TYPE_CHECKING:  # imported lazily: a judgement from the cache needs no definitions
    from rtgen.compiler.frontends import FrontendResult
    from rtgen.compiler.model.system_links import Known

_NO_SPAN = Span("", 1, 1, 1, 1)


class Judge:
    """Judges the connections of systems by the definitions of a project.

    Nothing is said of an end that the project does not define, or if its definitions have errors.
    Properties of connectors, and ports that are not there, are checked without it: a behaviour may
    create a port. `definitions` are those of the project after all lowerings, by default read when
    they are needed.
    """

    def __init__(
        self,
        project: Project,
        cache: Cache | None = None,
        definitions: FrontendResult | None = None,
    ) -> None:
        self._project = project
        self._cache = cache
        self._read = definitions

    def of_system(self, system: System, steps: Iterable[Step] = ()) -> Compilation:
        """Return the diagnostics about the connections of a system and of its timeline.

        The result has no artifacts.
        """
        made = [step for step in steps if isinstance(step.action, Connect)]
        topics = self._project.ros2.topics
        if not self._project.sources or not (system.connections or made or topics):
            return Compilation((), {})
        if self._cache is None:
            return self._judged(system, made)
        facts = [
            *((c.instance, c.type) for c in system.components),
            *(
                (
                    str(c.source),
                    str(c.target),
                    c.service,
                    c.properties,
                    c.places,
                    c.span,
                )
                for c in system.connections
            ),
            *((str(step.action), step.span) for step in made),
            *topics,
        ]
        key = self._cache.key(
            self._project,
            plugins.announced(plugins.Group.FRONTENDS),
            f"connections {sha256(repr(facts).encode()).hexdigest()}",
        )
        return self._cache.kept(key, lambda: self._judged(system, made))

    def of_ends(
        self,
        source: PortReference,
        target: PortReference,
        types: Mapping[str, str],
        properties: Mapping[str, str],
    ) -> Sequence[Diagnostic]:
        """Return the diagnostics about joining two ports; `types` are those of the instances."""
        from rtgen.compiler.systems.connections import link

        known = self._components_by_type
        ends = {name: known[type_] for name, type_ in types.items() if type_ in known}
        return _compared(link(source, target, properties, ends, _NO_SPAN), ends)

    def _judged(self, system: System, steps: Sequence[Step]) -> Compilation:
        from rtgen.compiler.model.system_links import definitions_of
        from rtgen.compiler.systems import connections, ros_topics
        from rtgen.compiler.systems.reading import as_defined
        from rtgen.compiler.systems.timeline_checks import new_connections

        links = new_connections(steps, system, self._components_by_type)
        whole = replace(system, connections=(*system.connections, *links))
        [named] = as_defined([whole], self._models)
        ends = definitions_of(named, self._components_by_type)
        findings = [*connections.twice(system)]
        findings += [d for c in named.connections for d in _compared(c, ends)]
        findings += ros_topics.findings(self._project.ros2.topics, ends)
        sources = _with_texts(self._definitions.sources, findings)
        hashes = self._definitions.hashes
        return Compilation((), {}, tuple(findings), hashes, sources)

    @property
    def _definitions(self) -> FrontendResult:
        if self._read is None:
            from rtgen.compiler import compilation

            self._read = compilation.read(self._project, lowered=True)
        return self._read

    @property
    def _models(self) -> Sequence[Model]:
        from rtgen.compiler.systems.reading import models_of

        return models_of(self._definitions) if self._project.sources else ()

    @cached_property
    def _components_by_type(self) -> Mapping[str, Known]:
        from rtgen.compiler.model.system_links import known_components

        return known_components(self._models)


def _compared(
    connection: Connection, ends: Mapping[str, Known]
) -> Sequence[Diagnostic]:
    from rtgen.compiler.systems.connection_rules import UNKNOWN_PORT
    from rtgen.compiler.systems.connections import compared

    return [d for d in compared(connection, ends) if d.code != UNKNOWN_PORT.code]


def _with_texts(
    sources: Mapping[str, str], findings: Sequence[Diagnostic]
) -> Mapping[str, str]:
    """Return the texts of definitions, and of the other files in diagnostics."""
    texts = dict(sources)
    for file in {d.span.file for d in findings if d.span is not None} - texts.keys():
        try:
            data = read_start(Path(file), MAX_BYTES)
        except OSError:
            continue  # the place remains, without the line
        texts[file] = decode(data, standard=True).normal
    return texts
