"""Reads the definitions and systems of a project, and the places of their names."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import msgspec

from rtgen.compiler import compilation
from rtgen.compiler.diagnostics import Diagnostic, has_errors
from rtgen.compiler.frontends import FrontendResult
from rtgen.compiler.frontends.cdl.names.table import Table
from rtgen.compiler.frontends.cdl.syntax.unit import Unit as CdlUnit
from rtgen.compiler.frontends.kit.memo import Memo
from rtgen.compiler.model import Model
from rtgen.compiler.project import Project, behaviours, shown
from rtgen.compiler.systems import reading, timeline_checks
from rtgen.facts.encodings import decode
from rtgen.facts.files import absolute_path, read_start
from rtgen.tools.indexing.cdl import CdlNames
from rtgen.tools.indexing.devices import BusNames, add_device
from rtgen.tools.indexing.followers import Followers, add_followers, content
from rtgen.tools.indexing.idl import IdlNames
from rtgen.tools.indexing.index import Collector, Index
from rtgen.tools.indexing.profiles import ProfileNames
from rtgen.tools.indexing.project_file import add_project_file
from rtgen.tools.indexing.text import Text

_MAX_SETTINGS_BYTES = 1024 * 1024
_MAX_HEADER_BYTES = 1024 * 1024


@dataclass(frozen=True, eq=False)
class Reading:
    """A project as it was read; `texts`, by displayed path, are its inputs.

    `of_systems` are the diagnostics of systems, `complete` the lowered definitions, None if the
    definitions have errors.
    """

    result: FrontendResult
    complete: FrontendResult | None
    of_systems: Sequence[Diagnostic]
    texts: Mapping[str, Text]
    index: Index
    followers: Followers


class _Names:
    """Collects the names that front ends resolve."""

    def __init__(self, collector: Collector) -> None:
        self.idl = IdlNames(collector)
        self._cdl = CdlNames(collector)

    def cdl(self, table: Table, units: Sequence[CdlUnit]) -> None:
        self._cdl.add(table, units)


def read(
    project: Project,
    memo: Memo,
    *,
    texts: Mapping[str, Text],
    before: Reading | None = None,
    others: Sequence[Path] = (),
) -> Reading:
    """Read a project, and `others`: further systems, timelines and `.conf` files.

    `texts` are those of an editor, by absolute path. `memo` caches the results of earlier readings.
    Files that cannot be read keep their names from `before`.
    """
    collector = Collector()
    memo.begin()
    result = compilation.read(project, observer=_Names(collector), memo=memo)
    complete = None
    if not has_errors(result.diagnostics):
        complete = compilation.read(project, lowered=True, memo=memo)
    of_systems: list[Diagnostic] = []
    result = _with_systems(project, result, complete, of_systems, memo)
    earlier = before.texts if before is not None else {}
    read_texts = _texts(project, result, earlier, texts)
    _add_unread(collector, read_texts, project.encoding)
    followers = _add_others(
        collector, project, result.model, complete, read_texts, others
    )
    files = {file.path: file for file in collector.indexes(read_texts)}
    for path, file in (before.index.files if before is not None else {}).items():
        if path not in files and (path in texts or Path(path).is_file()):
            files[path] = file
    index = Index(files.values())
    return Reading(result, complete, of_systems, read_texts, index, followers)


def _with_systems(
    project: Project,
    result: FrontendResult,
    complete: FrontendResult | None,
    findings: list[Diagnostic],
    memo: Memo,
) -> FrontendResult:
    """Return the result with the project's systems, whose diagnostics are added."""
    if not project.systems:
        return result
    read_systems = [_system(project, path, memo) for path in project.systems]
    systems = [system for each in read_systems for system in each.systems]
    _, more = reading.against(systems, complete or result, project.ros2.topics)
    findings += [*(d for each in read_systems for d in each.diagnostics), *more]
    findings += timeline_checks.findings(
        project.systems,
        project.encoding,
        reading.models_of(complete or result),
        behaviours.calls(project),
    )
    sources = {
        name: text for each in read_systems for name, text in each.sources.items()
    }
    return msgspec.structs.replace(
        result,
        model=msgspec.structs.replace(result.model, systems=tuple(systems)),
        sources={**result.sources, **sources},
    )


def _system(project: Project, path: Path, memo: Memo) -> reading.Systems:
    def make() -> reading.Systems:
        return reading.read(
            [path],
            root=project.root,
            output=project.output,
            encoding=project.encoding,
        )

    place = (str(Path.cwd()), project.root, project.output, path)
    key = ("system", *place, project.encoding)
    return memo.read(key, make, lambda each: each.dependencies[0].sha256 is not None)


def _texts(
    project: Project,
    result: FrontendResult,
    before: Mapping[str, Text],
    texts: Mapping[str, Text],
) -> dict[str, Text]:
    """Return the texts that were read: of an editor, or of `before` if unchanged."""
    sources = dict(result.sources)
    if project.file is not None:
        data = read_start(project.file, _MAX_SETTINGS_BYTES)
        sources[shown(project.file)] = decode(data, standard=True).normal
    current = {}
    for name, source in sources.items():
        text = texts.get(absolute_path(name)) or before.get(name)
        same = text is not None and text.normal == source
        current[name] = text if text is not None and same else Text(source)
    return current


def _add_unread(collector: Collector, texts: dict[str, Text], encoding: str) -> None:
    """Add the texts of C headers, which are not sources of diagnostics."""
    for file in collector.files:
        if file not in texts:
            try:
                data = read_start(Path(file), _MAX_HEADER_BYTES)
            except OSError:
                continue
            texts[file] = Text(decode(data, encoding).normal)


def _add_others(
    collector: Collector,
    project: Project,
    model: Model,
    complete: FrontendResult | None,
    texts: dict[str, Text],
    others: Sequence[Path],
) -> Followers:
    """Add the names of languages whose models have places, and of files that use them."""
    for device in model.devices:
        add_device(collector, device)
    described = {absolute_path(device.file) for device in model.devices}
    for bus in model.buses:
        for kind in bus.kinds:
            path = absolute_path(kind.device.file)
            if path not in described and kind.described is None:
                described.add(path)
                add_device(collector, kind.device)
        if bus.file in texts:
            BusNames(collector, bus, texts[bus.file]).add()
    profiles = ProfileNames(collector, texts)
    for profile in model.profiles:
        profiles.add_component(profile)
    followers = Followers(collector, model if complete is None else complete.model)
    paths = (*project.systems, *others)
    read_files = ((shown(path), content(path)) for path in dict.fromkeys(paths))
    files = [(name, data) for name, data in read_files if data is not None]
    add_followers(followers, files, texts, project.encoding)
    if project.file is not None:
        file = shown(project.file)
        add_project_file(collector, file, texts[file])
        followers.add_project_file(file, texts[file])
    return followers
