"""Runs the compiler, or takes the result from the cache if its inputs are unchanged."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rtgen.compiler.kit import plugins, stages
from rtgen.compiler.project import Project, behaviours
from rtgen.compiler.project.cache import Cache, hash_of
from rtgen.compiler.project.compilation import Compilation

if TYPE_CHECKING:  # imported lazily: a run from the cache needs no model
    from rtgen.compiler.diagnostics import Diagnostic
    from rtgen.compiler.frontends import FrontendResult
    from rtgen.compiler.frontends.kit.memo import Memo
    from rtgen.compiler.model import Model, System


class Definitions:
    """The definitions of a project, each form of which is read when it is first needed."""

    def __init__(self, project: Project) -> None:
        self._project = project
        self._read: dict[bool, FrontendResult] = {}
        self._memo: Memo | None = None

    def read(self, *, lowered: bool) -> FrontendResult:
        """Return what `compilation.read` does."""
        if lowered not in self._read:
            with stages.stage("import the compiler"):
                from rtgen.compiler import compilation
                from rtgen.compiler.frontends.kit.memo import Memo
            self._memo = self._memo or Memo()
            self._read[lowered] = compilation.read(
                self._project, lowered=lowered, memo=self._memo
            )
        return self._read[lowered]


def build(
    project: Project, cache: Cache | None, definitions: Definitions | None = None
) -> Compilation:
    """Return the project's artifacts."""

    def made() -> Compilation:
        read = (definitions or Definitions(project)).read(lowered=True)
        from rtgen.compiler.compilation import emitted

        return emitted(project, read)

    if cache is None:
        return made()
    with stages.stage("cache"):
        key = cache.key(project, plugins.announced(*plugins.Group))
    return cache.kept(key, made)


def of_behaviours(
    project: Project, run: Compilation, cache: Cache | None
) -> Compilation:
    """Return the diagnostics of behaviours, for the artifacts of a run."""
    modules = behaviours.modules(project, run.artifacts)

    def made() -> Compilation:
        hashes = {str(path.absolute()): hash_of(path) for path in modules}
        return Compilation(
            artifacts=(),
            inputs={},
            diagnostics=tuple(behaviours.check(project, run)),
            dependencies={**run.dependencies, **hashes},
        )

    if cache is None:
        return made()
    announced = plugins.announced(*plugins.Group)
    key = cache.key(project, announced, "behaviours", [*map(str, modules)])
    return cache.kept(key, made)


def inspect(
    project: Project | None,
    profiles: Sequence[Path],
    cache: Cache | None,
    *,
    as_json: bool,
) -> Compilation:
    """Return the model of a project's definitions and of system profiles as text: one artifact.

    It is cached unless there are profiles.
    """
    if cache is None or project is None or profiles:
        return _inspected(project, profiles, as_json)
    with stages.stage("cache"):
        key = cache.key(
            project,
            plugins.announced(plugins.Group.FRONTENDS),
            result="json" if as_json else "text",
        )
    return cache.kept(key, lambda: _inspected(project, (), as_json))


def _inspected(
    project: Project | None, profiles: Sequence[Path], as_json: bool
) -> Compilation:
    from msgspec.structs import replace

    from rtgen.compiler import compilation
    from rtgen.compiler.backends import Artifact
    from rtgen.compiler.diagnostics import in_order
    from rtgen.compiler.frontends import together
    from rtgen.compiler.inspection.models import json_text, tree

    result = together(()) if project is None else compilation.read(project)
    systems: list[System] = []
    diagnostics = list(result.diagnostics)
    sources = dict(result.sources)
    for profile in profiles:
        from rtgen.compiler.systems.reading import read_file

        system, findings, texts = read_file(profile)
        diagnostics += findings
        sources |= texts
        if system is not None:
            named, seen = _checked(system, project)
            systems += named
            diagnostics += seen
    model = replace(result.model, systems=tuple(systems))
    diagnostics = in_order(diagnostics)
    of_ros = {} if project is None else _of_ros(project, model)
    with stages.stage("print"):
        printer = (
            partial(json_text, model, diagnostics) if as_json else partial(tree, model)
        )
        text = printer(of_ros)
    return Compilation(
        artifacts=(Artifact("model", text, ()),),
        inputs={},
        diagnostics=tuple(diagnostics),
        dependencies=result.hashes,
        sources=sources,
    )


def _of_ros(project: Project, model: Model) -> dict[str, list[Any]]:
    """Return what boards are in ROS 2: services of TECS boards, nodes of CANopen buses."""
    of_ros: dict[str, list[Any]] = {}
    space = project.ros2.namespace
    if project.ros2.boards and model.tecs:
        from rtgen.compiler.lowering.tecs.boards import lower
        from rtgen.ros2.boards.interfaces import interfaces, service_facts

        made = interfaces(lower(model, project.lowering).model, project.package)
        of_ros["ros_services"] = [*service_facts(made, space)]
    if project.ros2.boards and model.buses:
        from rtgen.ros2.devices import device_facts, devices

        of_ros["ros_nodes"] = [*device_facts(devices(model), space)]
    return of_ros


def _checked(
    system: System, project: Project | None
) -> tuple[Sequence[System], Sequence[Diagnostic]]:
    """Return the system with the definitions' port names; without a project, unchanged.

    Without one, its connections are judged by the project around it.
    """
    from rtgen.compiler import compilation
    from rtgen.compiler.judging import Judge
    from rtgen.compiler.model.system_links import known_components
    from rtgen.compiler.project import load_around
    from rtgen.compiler.systems import checks, reading, timeline_checks

    path = Path(system.file)
    if project is None:
        of_properties = checks.as_warnings(checks.check_properties(system))
        around = load_around(path)
        definitions = compilation.read(around, lowered=True) if around.sources else None
        judgement = Judge(around, definitions=definitions).of_system(system)
        models = () if definitions is None else reading.models_of(definitions)
        of_properties += checks.as_warnings(
            checks.configurations(system, known_components(models))
        )
        of_timeline = timeline_checks.findings([path], models=models)
        return [system], [*of_properties, *judgement.diagnostics, *of_timeline]
    definitions = compilation.read(project, lowered=True)
    named, diagnostics = reading.against([system], definitions, project.ros2.topics)
    of_timeline = timeline_checks.findings(
        [path],
        project.encoding,
        reading.models_of(definitions),
        behaviours.calls(project),
    )
    return named, [*diagnostics, *of_timeline]
