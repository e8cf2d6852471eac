"""A rename as a whole: definitions, what follows them, and behaviours; nothing is written here."""

from __future__ import annotations

import ast
import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from rtgen.compiler import compilation
from rtgen.compiler.backends import Artifact, Owner
from rtgen.compiler.diagnostics import Diagnostic, Edit, InputError, Span, has_errors
from rtgen.compiler.frontends.kit import located_xml
from rtgen.compiler.frontends.kit.memo import Memo
from rtgen.compiler.lint.fixes import applied
from rtgen.compiler.project import Project, shown, skeletons
from rtgen.compiler.project.compilation import Compilation
from rtgen.facts.decoded_text import NotEncodableError
from rtgen.facts.encodings import decode
from rtgen.facts.files import absolute_path, overlaid, read_file
from rtgen.tools.indexing import reading
from rtgen.tools.indexing.followers import MAX_BYTES, PROFILE_SUFFIXES, files_below
from rtgen.tools.indexing.index import Kind
from rtgen.tools.indexing.reading import Reading
from rtgen.tools.indexing.text import Text
from rtgen.tools.renaming import definitions, python
from rtgen.tools.renaming.definitions import RenameError
from rtgen.tools.renaming.generated import Modules, renamed_names

_FOLLOWING = (*PROFILE_SUFFIXES, ".toml", ".conf")


@dataclass(slots=True)
class Renaming:
    """What a rename changes.

    `contents` has the old and the new bytes of each changed file by absolute path, `edits` the
    same for editors, by displayed path; `moves` pairs of absolute paths, of which the first is
    moved; the second is missing, or an untouched skeleton. `doubts` are uses that may have to be
    changed by hand. `old` and `new` are the names, `root` is the folder of the project.
    """

    old: str
    new: str
    root: Path
    contents: dict[str, tuple[bytes, bytes]] = field(default_factory=dict)
    edits: dict[str, list[Edit]] = field(default_factory=dict)
    moves: list[tuple[Path, Path]] = field(default_factory=list)
    doubts: list[Diagnostic] = field(default_factory=list)


def by_names(load: Callable[[], Project], old: str, new: str) -> Renaming:
    """Plan a rename of the files on the disk, whose definitions have the old or the new name.

    `load` returns the project as it is within `files.overlaid`. Raises InputError, and RenameError
    if the rename is impossible.
    """
    name = _last(old, new)
    before = _read(load(), {})
    keys = definitions.named(before.index, old)
    contents: dict[str, bytes] = {}
    if not keys:
        # The definitions are renamed already: what follows is renamed as if they were not.
        container = old.rpartition("::")[0] or old.rpartition(".")[0]
        separator = "::" if "::" in old else "."
        current = f"{container}{separator}{name}" if container else name
        keys = definitions.named(before.index, current)
        if not keys:
            message = f"no definition has the name {old}, nor {current}"
            raise RenameError(message, None, "rtgen inspect lists the names")
        last = old.removeprefix(container).lstrip(":.")
        for key in keys:
            definitions.check(before.index, key, last)
        contents = _contents(definitions.edits(before.index, keys, last), load(), {})
        with overlaid(contents):
            before = _read(load(), {})
            keys = definitions.named(before.index, old)
    return _planned(load, before, keys, name, contents, is_whole=not contents)


def by_key(
    load: Callable[[], Project],
    key: str,
    name: str,
    contents: Mapping[str, bytes],
    texts: Mapping[str, Text],
) -> Renaming:
    """Plan the rename of a key of the index, with an editor's `contents` and `texts`.

    Raises as `by_names` does.
    """
    with overlaid(contents):
        before = _read(load(), texts)
        keys = definitions.alike(before.index, key) or [key]
    return _planned(load, before, keys, name, contents)


def _last(old: str, new: str) -> str:
    """Return the last part of a new name, whose other parts are as in the old one."""
    parts = [part for part in new.replace("::", ".").split(".") if part]
    others = [part for part in old.replace("::", ".").split(".") if part][:-1]
    if not parts or (parts[:-1] and parts[:-1] != others[-len(parts) + 1 :]):
        raise RenameError(f"{new!r} is not a name beside {old!r}")
    return parts[-1]


def _read(project: Project, texts: Mapping[str, Text]) -> Reading:
    others = list(_below(project, _FOLLOWING))
    before = reading.read(project, Memo(), texts=texts, others=others)
    if has_errors(before.result.diagnostics):
        raise InputError([d for d in before.result.diagnostics if has_errors([d])])
    return before


def _below(project: Project, suffixes: Sequence[str]) -> Iterator[Path]:
    """Yield the files of a project that a user writes; a file alone has none beside it."""
    if project.file is not None:
        yield from files_below(project.root, suffixes, [project.output])


def _planned(
    load: Callable[[], Project],
    before: Reading,
    keys: Sequence[str],
    name: str,
    contents: Mapping[str, bytes],
    *,
    is_whole: bool = True,
) -> Renaming:
    for key in keys:
        definitions.check(before.index, key, name)
    definition = before.index.definition(keys[0])
    assert definition is not None
    result = Renaming(definition.name, name, load().root)
    span = definitions.span_of(before.index, definition)
    with overlaid(contents):
        project = load()
        files = dict(_users_files(project))
        edits = list(definitions.edits(before.index, keys, name))
        later = {**contents, **_contents(edits, project, contents)}
    with overlaid(later):
        new = _compiled(load())
    # Without users of generated modules, nothing follows what is generated.
    followed = bool(files or new.components.factories) or any(
        artifact.owner is Owner.USER for artifact in new.artifacts
    )
    with overlaid(contents):
        old = _emitted(project, before) if followed else new
    types = _renamed_types(old, new)
    further = _followed(before, types, keys)
    edits += further
    names = {**dict.fromkeys(keys, name), **_type_keys(before, types)}
    with overlaid(contents):
        of_python = _python(project, before, old, new, names, files, is_whole=is_whole)
        edits += [edit for each in of_python.edits.values() for edit in each]
        result.doubts = of_python.doubts
        for edit in edits:
            result.edits.setdefault(edit.span.file, []).append(edit)
        final = _contents(edits, project, contents)
    for path, data in final.items():
        there = read_file(Path(path), MAX_BYTES)
        if there != data:
            result.contents[path] = (there, data)
    old_types = types or {}
    if definition.kind is Kind.COMPONENT:
        old_types = {**old_types, definition.name: name}
    result.moves = [
        *_moved_skeletons(project, old, new, span),
        *_moved_settings(project, old_types, keys, name, span),
    ]
    return result


def _emitted(project: Project, before: Reading) -> Compilation:
    if before.complete is None:
        raise InputError([d for d in before.result.diagnostics if has_errors([d])])
    return _without_errors(compilation.emitted(project, before.complete))


def _compiled(project: Project) -> Compilation:
    return _without_errors(compilation.compile_project(project))


def _without_errors(run: Compilation) -> Compilation:
    if run.failed:
        raise InputError([d for d in run.diagnostics if has_errors([d])])
    return run


def _renamed_types(old: Compilation, new: Compilation) -> dict[str, str]:
    """Return the new names of component types, also of those made from devices and boards."""
    gone = [n for n in old.components.factories if n not in new.components.factories]
    come = [n for n in new.components.factories if n not in old.components.factories]
    return dict(zip(gone, come, strict=True)) if len(gone) == len(come) else {}


def _type_keys(before: Reading, types: Mapping[str, str]) -> dict[str, str]:
    known = before.followers.components.types
    return {known[old].key: new for old, new in types.items() if old in known}


def _followed(
    before: Reading, types: Mapping[str, str], keys: Sequence[str]
) -> Iterator[Edit]:
    """Yield the edits for component types whose names follow from those of others."""
    for key, name in _type_keys(before, types).items():
        if key not in keys:
            yield from definitions.edits(before.index, [key], name)


def _contents(
    edits: Iterable[Edit], project: Project, contents: Mapping[str, bytes]
) -> dict[str, bytes]:
    """Return the bytes of files with edits, by absolute path. Raises RenameError."""
    by_file: dict[str, list[Edit]] = {}
    for edit in edits:
        by_file.setdefault(edit.span.file, []).append(edit)
    changed = {}
    for file, of_file in by_file.items():
        path = absolute_path(file)
        data = contents.get(path) or read_file(Path(path), MAX_BYTES)
        changed[path] = _edited(file, data, of_file, project.encoding)
    return changed


def _edited(file: str, data: bytes, edits: Sequence[Edit], encoding: str) -> bytes:
    try:
        if file.lower().endswith(".xml"):
            text = located_xml.decode(data, file)
            return located_xml.encode(applied(text, edits), data)
        standard = file.endswith((".py", ".toml", ".yaml", ".yml"))
        read = decode(data, "auto" if standard else encoding, standard=standard)
        return read.encode(applied(read.text, edits))
    except NotEncodableError as error:
        raise RenameError(f"cannot change {file}: {error}", edits[0].span) from None


def _python(
    project: Project,
    before: Reading,
    old: Compilation,
    new: Compilation,
    keys: Mapping[str, str],
    files: Mapping[Path, str],
    *,
    is_whole: bool,
) -> python.PythonRename:
    if not files:
        return python.PythonRename()
    modules, others = Modules(), Modules()
    modules.add_artifacts(old.artifacts, project.skeleton_package)
    others.add_artifacts(new.artifacts, project.skeleton_package)
    names = dict(renamed_names(modules, others))
    for type_ in project.options.factories:
        # Its behaviour is where rtgen.toml says, under a name of its own.
        module = old.components.factories.get(type_, "").partition(":")[0]
        names = {n: v for n, v in names.items() if not f"{n}.".startswith(f"{module}.")}
    _add_modules(project, files, modules)
    with tempfile.TemporaryDirectory(prefix="rtgen-") as folder:
        _write(Path(folder), old.artifacts)
        sources = python.Sources(
            root=project.root,
            files=files,
            modules=modules,
            names=names,
            folders=(Path(folder), project.import_folders[1], project.root),
            components=before.followers.components,
            instances=before.followers.instances,
            keys=keys,
            is_whole=is_whole,
        )
        return python.renamed(sources)


def _users_files(project: Project) -> Iterator[tuple[Path, str]]:
    """Yield the modules of users with their texts."""
    folder = project.import_folders[1]
    places = {project.root, folder.parent, folder} if project.file else set[Path]()
    roots = [
        p for p in places if not any(p != q and p.is_relative_to(q) for q in places)
    ]
    for root in sorted(roots):
        for path in files_below(root, [".py"], [project.output]):
            try:
                text = decode(read_file(path, MAX_BYTES), standard=True).normal
            except OSError:
                continue
            yield path, text


def _add_modules(project: Project, files: Mapping[Path, str], modules: Modules) -> None:
    """Add the modules of users."""
    folder = project.import_folders[1]
    for path, text in files.items():
        start = folder if path.is_relative_to(folder) else project.root
        if path.is_relative_to(start):
            parts = path.relative_to(start).with_suffix("").parts
            is_package = parts[-1] == "__init__"
            name = ".".join(parts[:-1] if is_package else parts)
            if name:
                modules.add(name, text, is_package=is_package)


def _write(folder: Path, artifacts: Iterable[Artifact]) -> None:
    """Write the generated modules into a folder."""
    for artifact in artifacts:
        if artifact.owner is Owner.RTGEN and artifact.path.endswith((".py", ".typed")):
            path = folder / artifact.path
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(_with_operations(artifact.text), encoding="utf-8")


def _with_operations(text: str) -> str:
    """Return a generated module whose consumers have the operations of their interfaces.

    The runtime's have them by `__getattr__`, where nobody sees them without a run.
    """
    if "= consumer(" not in text:
        return text
    source = Text(text)
    ends = []
    for node in ast.walk(ast.parse(text)):
        match node:
            case ast.Call(func=ast.Name(id="consumer"), args=[interface, *_]):
                line, column = node.end_lineno or 1, node.end_col_offset or 0
                octets = text.split("\n")[line - 1].encode()[:column]
                place = source.whole_lines[line - 1] + len(octets.decode())
                ends.append((place, f" if consumer else {ast.unparse(interface)}()"))
    for place, more in sorted(ends, reverse=True):
        text = text[:place] + more + text[place:]
    return text


def _moved_skeletons(
    project: Project, old: Compilation, new: Compilation, span: Span
) -> Iterator[tuple[Path, Path]]:
    """Yield the behaviours that get the name of another module, and where to."""
    before, after = (
        {a.path: a for a in run.artifacts if a.owner is Owner.USER}
        for run in (old, new)
    )
    gone = [path for path in before if path not in after]
    come = [path for path in after if path not in before]
    for one, other in zip(gone, come, strict=False):
        source, target = project.skeletons / one, project.skeletons / other
        if source.is_file():
            if target.exists() and not skeletons.is_untouched(target):
                raise _in_the_way(target, span)
            yield source, target


def _moved_settings(
    project: Project,
    types: Mapping[str, str],
    keys: Sequence[str],
    name: str,
    span: Span,
) -> Iterator[tuple[Path, Path]]:
    """Yield the `.conf` files of renamed component types and instances, and where they go."""
    places: dict[Path, Path] = {}
    for path in _below(project, [".conf"]):
        if path.stem in types:
            places[path] = path.with_stem(types[path.stem])
        for key in keys:
            file, hash_, instance = key.partition("#")
            beside = Path(file.removeprefix("rts ")).parent == path.parent
            if hash_ and beside and path.stem == instance:
                places[path] = path.with_stem(name)
    for source, target in places.items():
        if target.exists():
            raise _in_the_way(target, span)
        yield source, target


def _in_the_way(target: Path, span: Span) -> RenameError:
    hint = "move it elsewhere, or give it its content by hand"
    return RenameError(f"{shown(target)} is there already", span, hint)
