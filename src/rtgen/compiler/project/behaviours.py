"""Checks the user's behaviour modules against the definitions; nothing of them is executed."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path, PurePosixPath

from rtgen.compiler.backends import Artifact, Owner
from rtgen.compiler.diagnostics import Diagnostic, Span, ToolError
from rtgen.compiler.kit import stages
from rtgen.compiler.project import Project, shown
from rtgen.compiler.project import behaviour_uses as uses
from rtgen.compiler.project.behaviour_classes import Modules
from rtgen.compiler.project.rules import (
    LEFTOVER_SKELETON,
    MISSPELT_CALLBACK,
    UNKNOWN_NAME,
)
from rtgen.compiler.typemap.components.actions import ACTIONS
from rtgen.facts.encodings import decode
from rtgen.facts.files import UnreadableError, is_file, read_file

RULES = (LEFTOVER_SKELETON, UNKNOWN_NAME, MISSPELT_CALLBACK)
"""The rules of behaviours."""

_CALLBACKS = frozenset(action.method for action in ACTIONS)
_MISSPELT = re.compile(
    rf"^ +def (?!(?:{'|'.join(sorted(_CALLBACKS))})\b)[oO]n\w+\(", re.M
)
"""A method that begins as callbacks do, and is none."""


def check(project: Project, artifacts: Sequence[Artifact]) -> list[Diagnostic]:
    """Return diagnostics for the modules in the folders of skeletons.

    `artifacts` are those of the current definitions. Raises ToolError for an unreadable module.
    """
    with stages.stage("check behaviours"):
        return [*_findings(project, artifacts)]


def misspelt_callbacks(project: Project) -> list[Diagnostic]:
    """Return diagnostics for misspelt callbacks in the modules of the folder of skeletons.

    Raises ToolError for an unreadable module.
    """
    with stages.stage("check behaviours"):
        return [
            f
            for file, text in _texts(project, ()).items()
            for f in _callbacks(project, file, text)
        ]


def _findings(project: Project, artifacts: Sequence[Artifact]) -> Iterator[Diagnostic]:
    base = f"{project.options.folder}/components/*/__init__.py"
    bases = {
        path.parent.name: artifact.text
        for artifact in artifacts
        if (path := PurePosixPath(artifact.path)).match(base)
    }
    if not bases:
        return
    imported = re.compile(
        rf"^from {re.escape(project.package)}\.components\.(\w+)(?:\.\w+)? import", re.M
    )
    texts = _texts(project, artifacts)
    known = Modules(
        {each.path: each.text for each in artifacts if each.owner is Owner.RTGEN},
        {uses.module_of(project, file): text for file, text in texts.items()},
    )
    for file, text in texts.items():
        yield from _callbacks(project, file, text)
        used = {match[1]: match for match in imported.finditer(text)}
        for module in used.keys() - bases.keys():
            near = _nearest(module, bases)
            yield LEFTOVER_SKELETON.at(
                _span(file, text, used[module].start(1), used[module].end(1)),
                f"no definition has the component of {project.package}.components.{module}",
                hint=f"was it renamed to {near}?" if near else "remove the file",
            )
        yield from uses.findings(project, known, file, text)


def modules(project: Project, artifacts: Sequence[Artifact]) -> list[Path]:
    """Return the modules beside skeletons. Raises ToolError."""
    folders = {project.skeletons}
    for artifact in artifacts:
        if artifact.owner is Owner.USER:
            folders.add((project.skeletons / artifact.path).parent)
    try:
        files = [f for each in sorted(folders) for f in sorted(each.glob("*.py"))]
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


def _callbacks(project: Project, file: str, text: str) -> Iterator[Diagnostic]:
    """Yield methods with nearly the name of a callback, which nothing in the module uses."""
    if not _MISSPELT.search(text):
        return
    try:
        tree = ast.parse(text)
    except (SyntaxError, ValueError, RecursionError):
        return  # reported when the module is imported
    bases = {
        alias.asname or alias.name
        for node in tree.body
        if isinstance(node, ast.ImportFrom)
        and (node.module or "").startswith(f"{project.package}.")
        for alias in node.names
        if alias.name.endswith("Base")
    }
    for node in tree.body:
        if not isinstance(node, ast.ClassDef) or not any(
            isinstance(base, ast.Name) and base.id in bases for base in node.bases
        ):
            continue
        for method in node.body:
            if not isinstance(method, ast.FunctionDef):
                continue
            near = _callback_meant(method.name)
            if near and len(re.findall(rf"\b{method.name}\b", text)) == 1:
                column = method.col_offset + len("def ")
                span = Span(
                    file,
                    method.lineno,
                    column + 1,
                    method.lineno,
                    column + 1 + len(method.name),
                )
                yield MISSPELT_CALLBACK.at(
                    span,
                    f"{method.name} is no callback of a component, and nothing calls it",
                    hint=f"did you mean {near}?",
                )


def _callback_meant(name: str) -> str | None:
    """Return the callback that a method is likely meant as: `onExecute`, `on_excute`."""
    if name in _CALLBACKS or not name.lower().startswith("on"):
        return None
    from difflib import get_close_matches

    folded = {each.replace("_", ""): each for each in _CALLBACKS}
    word = name.replace("_", "").lower()
    close = get_close_matches(word, folded, n=1, cutoff=0.85)
    return folded[close[0]] if close else None


def _nearest(word: str, candidates: Iterable[str]) -> str | None:
    # imported lazily, for reports only
    from rtgen.compiler.frontends.kit.suggestions import nearest

    return nearest(word, sorted(candidates))


def _span(file: str, text: str, begin: int, end: int) -> Span:
    line = text.count("\n", 0, begin) + 1
    column = begin - (text.rfind("\n", 0, begin) + 1) + 1
    return Span(file, line, column, line, column + end - begin)
