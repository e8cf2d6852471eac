"""Renames in the Python that users write: behaviours, tests, whatever imports generated names.

jedi resolves each name as the interpreter would; the names of ports and parameters in texts, as in
`system.connect(("Heater0", "temperature"), ...)`, are those of the instances beside them.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import Any

from rtgen import runtime
from rtgen.compiler.diagnostics import Diagnostic, Edit, Span
from rtgen.compiler.project import shown
from rtgen.compiler.project_rules import NOT_FOLLOWED
from rtgen.tools.indexing.components import KnownComponents
from rtgen.tools.indexing.text import Text
from rtgen.tools.renaming.definitions import RenameError
from rtgen.tools.renaming.generated import Modules, dotted


@dataclass(slots=True)
class PythonRename:
    """The edits of modules by displayed path, and warnings about uses that are not clear."""

    edits: dict[str, list[Edit]] = field(default_factory=dict)
    doubts: list[Diagnostic] = field(default_factory=list)


@dataclass(frozen=True)
class Sources:
    """What a rename of Python is about.

    `files` are the texts of users' modules by path, `modules` these and the generated ones before
    the rename, `names` the new last parts of absolute names in them. `folders` are searched for
    imports: the generated modules of before are in the first one. `keys` are the names renamed in
    definitions, `instances` the types of instances in systems. `is_whole`: no part of the rename
    has been done by hand.
    """

    root: Path
    files: Mapping[Path, str]
    modules: Modules
    names: Mapping[str, str]
    folders: Sequence[Path]
    components: KnownComponents
    instances: Mapping[str, str]
    keys: Mapping[str, str]
    is_whole: bool = True


def renamed(sources: Sources) -> PythonRename:
    """Return the edits of users' modules that a rename needs."""
    result = PythonRename()
    words = {name.rpartition(".")[2] for name in sources.names}
    pattern = re.compile(rf"\b(?:{'|'.join(map(re.escape, sorted(words)))})\b")
    in_texts = _Texts(sources)
    resolver: _Resolver | None = None
    for path, text in sources.files.items():
        file = shown(path)
        edits: dict[tuple[int, int], Edit] = {}
        if words and pattern.search(text):
            resolver = resolver or _Resolver(sources, words)
            for edit in resolver.edits(path, text, result.doubts):
                edits[edit.span.line, edit.span.column] = edit
        for edit in in_texts.edits(file, text):
            edits[edit.span.line, edit.span.column] = edit
        if edits and sources.is_whole:
            _check(file, text, edits.values())
        if edits:
            result.edits[file] = [edits[place] for place in sorted(edits)]
    return result


def _check(file: str, text: str, edits: Iterable[Edit]) -> None:
    """Raise RenameError if a module has something of a new name where it would be used."""
    modules = Modules()
    modules.add("module", text)
    scope = modules.find("module")
    assert scope is not None
    bound = scope.names.keys() | scope.imports.keys()
    lines = text.split("\n")
    for edit in edits:
        before = lines[edit.span.line - 1][: edit.span.column - 1]
        own = before.endswith("self.") and any(
            edit.new in each.names and edit.new not in bound
            for each in scope.names.values()
            if each.kind == "class"
        )
        if own or (edit.old in bound and edit.new in bound):
            message = f"{file} has something that is called {edit.new}"
            raise RenameError(message, edit.span, "give that another name first")


class _Resolver:
    """Finds the names of modules that are renamed."""

    def __init__(self, sources: Sources, words: set[str]) -> None:
        # imported lazily: no other command needs it
        import sys

        import jedi

        self._sources = sources
        self._words = words
        folders = [*map(str, sources.folders), *sys.path]
        self._environment = jedi.InterpreterEnvironment()
        self._project = jedi.Project(
            str(sources.root), sys_path=folders, smart_sys_path=False
        )
        self._script: Callable[..., Any] = jedi.Script
        self._members = {
            name.rpartition(".")[2]
            for name, scope, _ in sources.modules.definitions()
            if scope.kind in ("class", "function") and self._of_definition(name)
        } - _names_of_the_runtime()
        """The last parts of the names of members and arguments that are renamed."""

    def edits(self, path: Path, text: str, doubts: list[Diagnostic]) -> Iterator[Edit]:
        """Yield the edits of a module."""
        script = self._script(
            text, path=str(path), project=self._project, environment=self._environment
        )
        lines = text.split("\n")
        keywords = _keywords(text)
        for name in script.get_names(
            all_scopes=True, definitions=True, references=True
        ):
            old: str = name.name
            if old not in self._words:
                continue
            span = Span(
                shown(path),
                *(name.line, name.column + 1, name.line, name.column + 1 + len(old)),
            )
            before = lines[name.line - 1][: name.column].rstrip()
            is_attribute = before.endswith(".")
            new = self._new_name(name, is_attribute)
            function = keywords.get((name.line, name.column))
            if new is None and function is not None:
                functions = script.goto(*function.name, follow_imports=True)
                new = self._argument(functions, old)
                if new is None and function.first and _is_replace(functions):
                    new = self._member(script.infer(*function.first), old)
            is_member = is_attribute or function is not None
            if new == "" or (new is None and is_member and self._is_doubtful(name)):
                doubts.append(self._doubt(span, old))
            elif new is not None:
                yield Edit(span, old, new)

    def _doubt(self, span: Span, word: str) -> Diagnostic:
        return NOT_FOLLOWED.at(
            span,
            f"the type of what {word!r} belongs to is not clear",
            hint=f"annotate it, or write {self._other(word)} if that is meant",
        )

    def _other(self, word: str) -> str:
        names = self._sources.names.items()
        return " or ".join(
            sorted({new for old, new in names if old.rpartition(".")[2] == word})
        )

    def _new_name(self, name: Any, is_attribute: bool) -> str | None:
        """Return the new name of a use, None if it is not of something renamed.

        It is empty if the use can be of something else as well.
        """
        found = {
            self._by_definition(name.name, definition, is_attribute)
            for definition in _definitions(name)
        }
        return found.pop() if len(found) == 1 else "" if found else None

    def _by_definition(
        self, word: str, definition: Any, is_attribute: bool
    ) -> str | None:
        full = definition.full_name
        parent = definition.parent()
        if definition.type == "instance":  # an enumerator, of the class
            full, parent = f"{full}.{word}", None
        if full is None and parent is not None and parent.full_name:
            full = f"{parent.full_name}.{definition.name}"
        if full is None or full in self._sources.names:
            return None if full is None else self._sources.names[full]
        in_class = parent is not None and parent.type == "class"
        if not (in_class or is_attribute or definition.type == "module"):
            return None
        scope: str = full.rpartition(".")[0]
        while scope:
            found = self._sources.modules.find(scope)
            if found is not None and found.kind == "class":
                return self._inherited(scope, word)
            scope = scope.rpartition(".")[0]
        return None

    def _of_definition(self, name: str) -> str | None:
        """Return the new last part of what generated code, or a class derived from it, defines."""
        scope, _, word = name.rpartition(".")
        found = self._sources.modules.find(scope) if scope else None
        if found is not None and found.kind == "class":
            return self._inherited(scope, word)
        return self._sources.names.get(name)

    def _inherited(self, of: str, word: str) -> str | None:
        for base in self._sources.modules.bases(of):
            new = self._sources.names.get(f"{base}.{word}")
            if new is not None:
                return new
        return None

    def _argument(self, functions: Iterable[Any], word: str) -> str | None:
        """Return the new name of an argument that one of the functions is called with."""
        for function in functions:
            scope, _, method = (function.full_name or "").rpartition(".")
            for base in self._sources.modules.bases(scope) if scope else ():
                new = self._sources.names.get(f"{base}.{method}.{word}")
                if new is not None:
                    return new
        return None

    def _member(self, types: Iterable[Any], word: str) -> str | None:
        """Return the new name of a member of one of the types."""
        found = (
            self._inherited(each.full_name, word) for each in types if each.full_name
        )
        return next((new for new in found if new is not None), None)

    def _is_doubtful(self, name: Any) -> bool:
        """Return whether nothing is known of what has a member or argument of that name."""
        return name.name in self._members and not _definitions(name)


def _names_of_the_runtime() -> set[str]:
    """Return the names of members of the runtime's classes, which a rename never means."""
    classes = (each for each in vars(runtime).values() if isinstance(each, type))
    return {name for each in classes for name in dir(each)}


def _definitions(name: Any) -> list[Any]:
    found: list[Any] = name.goto(follow_imports=True)
    return [each for each in found if each.type != "namespace"]


def _is_replace(functions: Iterable[Any]) -> bool:
    """Return whether a function copies its first argument with other values of members."""
    return any((each.full_name or "").endswith(".replace") for each in functions)


@dataclass(frozen=True, slots=True)
class _Call:
    """The places of the name of a function, and of the end of its first argument."""

    name: tuple[int, int]
    first: tuple[int, int] | None


def _keywords(text: str) -> dict[tuple[int, int], _Call]:
    """Return the calls of a module by the places of their keyword arguments."""
    try:
        tree = ast.parse(text)
    except (SyntaxError, ValueError, RecursionError):
        return {}
    lines = text.split("\n")

    def place(line: int, octets: int) -> tuple[int, int]:
        return line, len(lines[line - 1].encode()[:octets].decode(errors="replace"))

    def end(node: ast.expr) -> tuple[int, int]:
        return place(node.end_lineno or 1, (node.end_col_offset or 1) - 1)

    return {
        place(keyword.lineno, keyword.col_offset): _Call(
            end(node.func), end(node.args[0]) if node.args else None
        )
        for node in ast.walk(tree)
        if isinstance(node, ast.Call)
        for keyword in node.keywords
        if keyword.arg is not None
    }


class _Texts:
    """Finds names of ports and parameters in texts of Python."""

    def __init__(self, sources: Sources) -> None:
        self._sources = sources
        self._types = {
            name: scope.type_name
            for name, _, scope in sources.modules.definitions()
            if scope.type_name
        }
        last = {re.split(r"[ .:]", key)[-1] for key in sources.keys}
        self._words = re.compile(rf"\b(?:{'|'.join(map(re.escape, last))})\b")

    def edits(self, file: str, text: str) -> Iterator[Edit]:
        """Yield the edits of the texts of a module."""
        if not self._sources.keys or self._words.search(text) is None:
            return
        try:
            tree = ast.parse(text)
        except (SyntaxError, ValueError, RecursionError):
            return
        places = _Places(file, text)
        instances = {**self._sources.instances, **self._instances(tree)}
        for node in ast.walk(tree):
            match node:
                case ast.Constant(value=str(value)):
                    yield from self._paths(places, node, value, instances)
                case ast.Tuple(elts=items) | ast.List(elts=items):
                    yield from self._pairs(places, items, instances)
                case ast.Call(args=items):
                    yield from self._pairs(places, items, instances)

    def _instances(self, tree: ast.Module) -> dict[str, str]:
        """Return the types of the instances that a module makes: `Heater("Heater0")`."""
        imports = Modules()
        imports.add("module", ast.unparse(tree))
        scope = imports.find("module")
        found = {}
        for node in ast.walk(tree):
            match node:
                case ast.Call(func=func, args=[ast.Constant(value=str(name)), *_]):
                    start, _, rest = dotted(func).partition(".")
                    source = scope.imports.get(start) if scope is not None else None
                    if source is None:
                        continue
                    full = f"{source}.{rest}" if rest else source
                    for base in self._sources.modules.bases(full):
                        if base in self._types:
                            found[name] = self._types[base]
                            break
        return found

    def _paths(
        self,
        places: _Places,
        node: ast.Constant,
        value: str,
        instances: Mapping[str, str],
    ) -> Iterator[Edit]:
        for start, end, key in self._sources.components.paths(value, instances):
            new = self._sources.keys.get(key)
            before = value[:start].rsplit("\n", 1)[-1]
            if new is not None:
                yield from places.edit(node, before, value[start:end], new)

    def _pairs(
        self,
        places: _Places,
        items: Sequence[ast.expr],
        instances: Mapping[str, str],
    ) -> Iterator[Edit]:
        for one, other in pairwise(items):
            match one, other:
                case (ast.Constant(value=str(instance)), ast.Constant(value=str(name))):
                    names = self._sources.components.types.get(
                        instances.get(instance, "")
                    )
                    key = "" if names is None else names.own.get(name, "")
                    new = self._sources.keys.get(key)
                    if new is not None:
                        yield from places.edit(other, "", name, new)


class _Places:
    """Places of parts of literals in a module."""

    def __init__(self, file: str, text: str) -> None:
        self._file = file
        self._text = Text(text)
        self._lines = text.split("\n")

    def edit(self, node: ast.expr, before: str, old: str, new: str) -> Iterable[Edit]:
        """Return the edit of a word after `before` in a literal, none if it is not found."""
        end_line = node.end_lineno or node.lineno
        start = self._offset(node.lineno, node.col_offset)
        end = self._offset(end_line, node.end_col_offset or 0)
        literal = self._text.source[start:end]
        place = literal.find(before + old)
        if place < 0:
            return ()
        begin = start + place + len(before)
        return (Edit(self._text.span(self._file, begin, begin + len(old)), old, new),)

    def _offset(self, line: int, column: int) -> int:
        octets = self._lines[line - 1].encode()[:column]
        return self._text.whole_lines[line - 1] + len(octets.decode(errors="replace"))
