"""Cache of complete runs: artifacts by their inputs.

The key covers the tool and the options. An entry lists all files that the run read or searched for;
it is valid while they are unchanged. An entry is a JSON text after a line with its hash. Damaged
entries are ignored, and so are those that another user may have written.
"""

from __future__ import annotations

import contextlib
import json
import os
import sys
from collections.abc import Callable, Sequence
from functools import cache
from hashlib import sha256
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec
from msgspec.structs import replace

from rtgen.compiler.backends import Artifact
from rtgen.compiler.kit import stages, stored_files
from rtgen.compiler.kit.own_files import (
    compiler_folders,
    read_own,
    stamp,
    stamp_of,
)
from rtgen.compiler.project.compilation import Compilation
from rtgen.compiler.project.kinds import is_component_profile
from rtgen.compiler.project.loading import Project
from rtgen.facts.files import MAX_BYTES, read_start, real_path

if TYPE_CHECKING:
    from importlib import metadata

_FORMAT = "rtgen-run/7"
_LIBRARIES = {"artifacts": ("jinja2", "lark")}
"""Libraries whose versions affect the output."""


def _searched(project: Project) -> list[str]:
    """Return the IDL files in which the types of profiles are searched."""
    profiles = [path for path in project.sources if is_component_profile(path)]
    if not profiles:
        return []
    from rtgen.compiler.frontends.profiles.rtc_profile.idl_search import candidates

    places = project.root, project.include, project.sources
    return [str(each) for path in profiles for each in candidates(path, *places)]


class Cache:
    """A folder of entries, bounded in number and size; concurrent runs can share it."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def key(
        self,
        project: Project,
        plugins: Sequence[metadata.EntryPoint],
        result: str = "artifacts",
        also: Sequence[str] = (),
    ) -> str:
        """Return the hash of everything except the definitions that affects the output.

        `also` is what else affects a result of the kind `result`.
        """
        content = [
            _FORMAT,
            [result, *also],
            sys.version_info[:3],
            _compiler(),
            [(name, _version(name)) for name in _LIBRARIES.get(result, ())],
            [(e.name, e.value, _plugin(e)) for e in plugins],
            str(Path.cwd()),
            str(project.root),
            list(map(str, project.sources)),
            (
                [str(project.output), *map(str, project.emitted_systems)]
                if project.emitted_systems
                else []
            ),
            list(map(str, project.include)),
            _searched(project),
            project.define,
            project.ignore_case_clashes,
            project.prelude,
            project.encoding,
            [problem.message for problem in project.problems],
            list(map(str, project.tecs_path)),
            project.node_id,
            [
                (
                    *(a.name, a.source, a.target, a.mapping, a.constants),
                    *(list(a.units.items()), str(a.span)),
                )
                for a in project.adapters
            ],
            [
                project.package,
                project.skeleton_package,
                project.target,
                project.small,
                project.representation,
                project.extensibility,
                project.ros2.interfaces,
                project.options.ros_boards,
                project.numeric,
                project.tecs_corba,
                project.components,
                project.skeleton_path,
            ],
            json.dumps(project.plugins, default=str, sort_keys=True),
            [(n, str(p), hash_of(p)) for n, p in sorted(project.templates.items())],
        ]
        return sha256(json.dumps(content).encode()).hexdigest()

    def kept(self, key: str, make: Callable[[], Compilation]) -> Compilation:
        """Return the entry of a key; else the result of `make`, stored unless it has errors."""
        with stages.stage("cache"):
            compilation = self.load(key)
            stages.note("miss" if compilation is None else "hit")
        if compilation is None:
            compilation = make()
            if not compilation.failed:
                with stages.stage("store in cache"):
                    self.store(key, compilation)
        return compilation

    def load(self, key: str) -> Compilation | None:
        """Return the entry of a key, if it exists and its dependencies are unchanged."""
        file = self._file(key)
        content = read_own(str(file), stored_files.MAX_BYTES + 1) or b""
        head, _, payload = content.partition(b"\n")
        digest, _, places = head.partition(b" ")
        if digest != sha256(payload).hexdigest().encode():
            return None
        try:
            run = msgspec.json.decode(payload, type=Compilation)
        except ValueError:
            return None
        if places != _places(run).encode():
            return None
        if any(hash_of(Path(path)) != d for path, d in run.dependencies.items()):
            return None
        with contextlib.suppress(OSError):
            os.utime(file)  # for `_trim`
        return replace(
            run, artifacts=tuple(run.artifacts), declared=tuple(run.declared)
        )

    def store(self, key: str, run: Compilation) -> None:
        """Store a run without errors, unless the folder is read-only or another user's."""
        shown = _files_in_diagnostics(run)
        entry = replace(
            run,
            artifacts=[
                Artifact(a.path, a.text, a.origin, a.owner) for a in run.artifacts
            ],
            sources={f: text for f, text in run.sources.items() if f in shown},
        )
        try:
            payload = msgspec.json.encode(entry, enc_hook=str)  # texts are `Code`
        except UnicodeEncodeError:
            return  # the name of a file is not text
        head = f"{sha256(payload).hexdigest()} {_places(run)}\n"
        data = head.encode() + payload
        stored_files.write(self._folder, self._file(key).name, data)

    def _file(self, key: str) -> Path:
        return self._folder / f"{key}.json"


def default() -> Cache:
    """Return the user's cache."""
    return Cache(stored_files.folder())


def _places(run: Compilation) -> str:
    """Return the hash of where links lead from the paths of a run: files are named by that."""
    return _hash("\0".join(map(real_path, run.dependencies)))


def _files_in_diagnostics(run: Compilation) -> set[str]:
    """Return the files with lines that diagnostics show."""
    spans = [d.span for d in run.diagnostics]
    spans += [related.span for d in run.diagnostics for related in d.related]
    return {span.file for span in spans if span is not None}


def _version(library: str) -> str:
    spec = find_spec(library)
    if spec is not None and spec.origin is not None:
        beside = Path(spec.origin).parents[1].glob(f"{library}-*.dist-info")
        names = sorted(folder.name for folder in beside)
        if names:
            return " ".join(names)
    from importlib import metadata

    return metadata.version(library)


def hash_of(path: Path) -> str | None:
    """Return the SHA-256 of a dependency; None for a file that is missing or cannot be read."""
    try:
        return sha256(read_start(path, MAX_BYTES + 1)).hexdigest()
    except OSError:
        return None


@cache
def _compiler() -> str:
    """Return the stamp of the compiler, which does not change while it runs."""
    return _hash(stamp(compiler_folders()))


def _hash(text: str) -> str:
    return sha256(os.fsencode(text)).hexdigest()


def _plugin(entry: metadata.EntryPoint) -> str:
    """Return the stamp of a plug-in's package."""
    spec = find_spec(entry.module.partition(".")[0])
    if spec is None:
        return ""
    folders = [*filter(os.path.isdir, spec.submodule_search_locations or ())]
    if spec.origin and not spec.submodule_search_locations:
        return _hash(stamp_of(spec.origin))
    return _hash(stamp(folders, skip=("__pycache__",)))
