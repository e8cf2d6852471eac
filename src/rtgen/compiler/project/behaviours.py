"""Checks the user's behaviour modules against the definitions; nothing of them is executed."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import cached_property
from pathlib import Path, PurePosixPath

from rtgen.compiler.backends import Artifact, Owner
from rtgen.compiler.diagnostics import Diagnostic, Span, ToolError
from rtgen.compiler.kit import stages
from rtgen.compiler.project import Project, behaviour_callbacks, renames, shown
from rtgen.compiler.project import behaviour_uses as uses
from rtgen.compiler.project.behaviour_classes import Modules
from rtgen.compiler.project.compilation import Compilation, Declared
from rtgen.compiler.project.skeletons import is_skeleton
from rtgen.compiler.project_rules import (
    LEFTOVER_SKELETON,
    MISSPELT_CALLBACK,
    NO_ANSWER,
    NO_BEHAVIOUR,
    NOT_PYTHON,
    UNKNOWN_NAME,
)
from rtgen.facts.encodings import decode
from rtgen.facts.files import UnreadableError, exists, is_file, modules_in, read_file

RULES = (
    LEFTOVER_SKELETON,
    UNKNOWN_NAME,
    MISSPELT_CALLBACK,
    NO_ANSWER,
    NOT_PYTHON,
    NO_BEHAVIOUR,
)
"""The rules of behaviours."""

_CLASS = re.compile(r"^class (\w+)", re.M)


def check(project: Project, run: Compilation) -> list[Diagnostic]:
    """Return diagnostics for the modules in the folders of skeletons.

    `run` is that of the current definitions. Raises ToolError for an unreadable module.
    """
    with stages.stage("check behaviours"):
        return [*Behaviours(project, run.artifacts, run.declared).findings()]


def awaited(project: Project, artifacts: Sequence[Artifact]) -> frozenset[str]:
    """Return the skeletons that are not made, since a behaviour of before is likely theirs.

    Raises ToolError for an unreadable module.
    """
    missing = [
        each
        for each in artifacts
        if each.owner is Owner.USER and not exists(project.skeletons / each.path)
    ]
    return Behaviours(project, artifacts).awaited() if missing else frozenset()


class Behaviours:
    """The user's behaviours beside the artifacts of the current definitions."""

    def __init__(
        self,
        project: Project,
        artifacts: Sequence[Artifact],
        declared: Iterable[Declared] = (),
    ) -> None:
        self._project = project
        self._declared = {each.name: each.span for each in declared}
        self._artifacts = artifacts
        base = f"{project.options.folder}/components/*/__init__.py"
        self._bases = {
            path.parent.name: artifact.text
            for artifact in artifacts
            if (path := PurePosixPath(artifact.path)).match(base)
        }
        self._texts = _texts(project, artifacts) if self._bases else {}
        pattern = (
            rf"^from {re.escape(project.package)}\.components\.(\w+)(?:\.\w+)? import"
        )
        imported = re.compile(pattern, re.M)
        self._used = {
            file: {match[1]: match for match in imported.finditer(text)}
            for file, text in self._texts.items()
        }
        self._orphans = {
            module: renames.Orphan(module, self._texts[file], self._former(module))
            for file, used in self._used.items()
            for module in used.keys() - self._bases.keys()
        }

    def _former(self, module: str) -> str:
        """Return the generated module of a former component, if it is still there."""
        folder = self._project.output / self._project.options.folder / "components"
        path = folder / module / "__init__.py"
        return _text(path) if is_file(path) else ""

    @cached_property
    def _became(self) -> Mapping[str, tuple[str, ...]]:
        """The modules that the component of each orphan may have now."""
        busy = {
            module
            for file, used in self._used.items()
            for module in used
            if not is_skeleton(self._texts[file])
        }
        newcomers = {m: text for m, text in self._bases.items() if m not in busy}
        return renames.became([*self._orphans.values()], newcomers)

    def awaited(self) -> frozenset[str]:
        """Return the paths of skeletons in whose place a behaviour will be moved."""
        if not self._orphans:
            return frozenset()
        possible = {module for some in self._became.values() for module in some}
        imports = tuple(
            f"from {self._project.package}.components.{module} import"
            for module in possible
        )
        return frozenset(
            artifact.path
            for artifact in self._artifacts
            if artifact.owner is Owner.USER and any(i in artifact.text for i in imports)
        )

    def findings(self) -> Iterator[Diagnostic]:
        """Yield the diagnostics of all behaviours."""
        if not self._bases:
            return
        project = self._project
        known = Modules(
            {e.path: e.text for e in self._artifacts if e.owner is Owner.RTGEN},
            {uses.module_of(project, file): t for file, t in self._texts.items()},
        )
        yield from self._missing(known)
        skeletons = {e.text for e in self._artifacts if e.owner is Owner.USER}
        for file, text in self._texts.items():
            if text in skeletons:  # as rtgen has written it
                continue
            yield from behaviour_callbacks.findings(
                project.package, file, text, known.tree
            )
            used = self._used[file]
            for module in used.keys() - self._bases.keys():
                yield LEFTOVER_SKELETON.at(
                    _span(file, text, used[module].start(1), used[module].end(1)),
                    f"no definition has the component of {project.package}.components.{module}",
                    hint=self._renamed(module),
                )
            yield from uses.findings(project, known, file, text)
            known.forget(uses.module_of(project, file))

    def _missing(self, known: Modules) -> Iterator[Diagnostic]:
        """Yield the components whose module, or class in it, is not where a run looks for it."""
        awaited = self.awaited()
        elsewhere = dict(self._project.components)
        for artifact in self._artifacts:
            if artifact.owner is not Owner.USER or artifact.path in awaited:
                continue
            name = [*re.finditer(r"^class (\w+)\(", artifact.text, re.M)][-1][1]
            file = self._project.skeletons / artifact.path
            if name in elsewhere:
                continue
            if not is_file(file):
                yield NO_BEHAVIOUR.at(
                    self._declared.get(name),
                    f"{shown(file)}, the behaviour of {name}, does not exist",
                    hint="rtgen generate creates its skeleton",
                )
                continue
            if name in _CLASS.findall(self._texts[shown(file)]):
                continue
            module = uses.module_of(self._project, shown(file))
            names = known.bound_in(module)
            if names is not None and name not in names:
                found = known.find(module)
                near = _nearest(name, found.classes if found else ())
                advice = f"rename {near}" if near else "define it"
                yield NO_BEHAVIOUR.at(
                    Span(shown(file), 1, 1, 1, 2),
                    f"the module has no class {name}, the behaviour that a run looks for here",
                    hint=f"{advice}, or name it in [components] of rtgen.toml",
                )

    def _renamed(self, module: str) -> str:
        """Return what to do about a behaviour whose component has gone."""
        old = self._orphans[module].name
        names = [renames.type_name(self._bases[m]) for m in self._became[module]]
        if not names:
            return (
                f"if {old} has another name now: rtgen generate --rename {old}=NAME;"
                " the file is yours, and stays as it is"
            )
        commands = " or ".join(
            f"rtgen generate --rename {old}={name}" for name in names
        )
        return f"was it renamed to {' or '.join(names)}? {commands}"


def check_texts(project: Project) -> list[Diagnostic]:
    """Return what the modules of the folder of skeletons show by themselves.

    These are texts that are not Python, and misspelt callbacks.

    Raises ToolError for an unreadable module.
    """
    with stages.stage("check behaviours"):
        return [
            f
            for file, text in _texts(project, ()).items()
            for f in behaviour_callbacks.findings(project.package, file, text)
        ]


def calls(project: Project) -> Callable[[str, str], bool] | None:
    """Return the function that tells whether the behaviour of a component type uses a port.

    None if nodes of ROS 2, which the project has settings for, may serve it.
    """
    if project.ros2.is_used:
        return None
    texts: list[str] = []

    def uses_port(type_name: str, port: str) -> bool:
        if not texts:
            texts.extend(_texts(project, ()).values())
        return any(
            type_name in _CLASS.findall(text) and re.search(rf"\.{port}\b", text)
            for text in texts
        )

    return uses_port


def modules(project: Project, artifacts: Sequence[Artifact]) -> list[Path]:
    """Return the modules beside skeletons. Raises ToolError."""
    folders = {project.skeletons}
    for artifact in artifacts:
        if artifact.owner is Owner.USER:
            folders.add((project.skeletons / artifact.path).parent)
    try:
        files = [f for each in sorted(folders) for f in modules_in(each)]
    except OSError as error:
        raise ToolError(f"cannot read {error.filename}: {error.strerror}") from error
    return [file for file in files if is_file(file)]


def _texts(project: Project, artifacts: Sequence[Artifact]) -> Mapping[str, str]:
    """Return the texts of the modules beside skeletons, by displayed path."""
    return {shown(file): _text(file) for file in modules(project, artifacts)}


def _text(file: Path) -> str:
    try:
        return decode(read_file(file), standard=True).normal
    except UnreadableError as error:
        raise ToolError(f"cannot read {shown(file)}: {error}") from error


def _nearest(word: str, candidates: Iterable[str]) -> str | None:
    # imported lazily, for reports only
    from rtgen.compiler.frontends.kit.suggestions import nearest

    return nearest(word, sorted(candidates))


def _span(file: str, text: str, begin: int, end: int) -> Span:
    line = text.count("\n", 0, begin) + 1
    column = begin - (text.rfind("\n", 0, begin) + 1) + 1
    return Span(file, line, column, line, column + end - begin)
