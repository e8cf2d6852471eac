"""The modules of a component: its own, and those that it imports from the repository."""

from __future__ import annotations

import ast
import os
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from rtgen.openrtm.python_modules.search_path import added_folders
from rtgen.openrtm.python_modules.source import Source, read_source
from rtgen.openrtm.python_modules.values import Class, Function, Module, Named, Value

_MAX_MODULES = 50
_MAX_FOLDERS = 6
_MAX_SEARCHED = 5000
"""Maximum number of files among which a module is searched for a hint."""
_STUBS = "import omniORB"
_OPENRTM = (("OpenRTM_aist",), ("omniORB",), ("RTC",))
"""Packages of OpenRTM itself."""


@dataclass(eq=False, slots=True)
class ModuleName:
    """A module as a value; a missing attribute of the module may be a submodule."""

    module: Module
    path: tuple[str, ...]

    def attribute_of(self, name: str) -> Value:
        """Return the definition of an attribute."""
        value = self.module.find(name)
        if isinstance(value, Named) or value is None:
            return Named((*self.path, name), imported=True)
        return value


class Modules:
    """Finds and reads modules of the same repository; stubs of omniidl are not read."""

    def __init__(self, first: Source, path: Path, include: Sequence[Path]) -> None:
        """Search for the modules that a first one imports.

        `include` are further folders; those that modules add to `sys.path` are searched if they are
        in the repository.
        """
        self.sources: list[Source] = []
        self._folders = [*_folders(path.parent), *include]
        self._root = [*_folders(path.parent)][-1]
        self._add_folders(first, path)
        self._read: dict[Path, Module | None] = {}
        self._listed: dict[Path, frozenset[str]] = {}

    def imported(self, path: tuple[str, ...], of: Path, level: int) -> Module | None:
        """Return the imported module; None if it is not in the repository."""
        if path[:1] in _OPENRTM:
            return None
        if level:
            folder = of.parent
            for _ in range(level - 1):
                folder = folder.parent
            return self._in(folder, path)
        modules = (self._in(folder, path) for folder in [of.parent, *self._folders])
        return next((each for each in modules if each is not None), None)

    def _in(self, folder: Path, path: tuple[str, ...]) -> Module | None:
        first = path[0]
        if self._entries(folder).isdisjoint((first, f"{first}.py")):
            return None
        place = folder.joinpath(*path)
        for file in (place.with_name(f"{place.name}.py"), place / "__init__.py"):
            if file in self._read:
                return self._read[file]
            if len(self._read) < _MAX_MODULES and file.is_file():
                self._read[file] = self._module(file)
                return self._read[file]
        return None

    def elsewhere(self, path: tuple[str, ...], name: str) -> list[Path]:
        """Return the files of the repository that may be a module that has a class."""
        matches: list[Path] = []
        file_name = f"{path[-1]}.py"
        declares = re.compile(rf"^class\s+{re.escape(name)}\b", re.MULTILINE)
        remaining = _MAX_SEARCHED
        for folder, below, files in os.walk(self._root):
            below[:] = sorted(each for each in below if not each.startswith("."))
            remaining -= len(files)
            if file_name in files:
                file = Path(folder, file_name)
                if declares.search(read_source(file).text):
                    matches.append(file)
            if remaining < 0:
                break
        return matches

    def search_in(self, folder: Path) -> None:
        """Search in a further folder, too."""
        self._folders.append(folder)

    def _add_folders(self, source: Source, path: Path) -> None:
        """Search in the folders that a module adds to `sys.path`, too."""
        if source.tree is None:
            return
        for folder in added_folders(source.tree, path.absolute()):
            if folder.is_relative_to(self._root) and folder not in self._folders:
                self._folders.append(folder)

    def _entries(self, folder: Path) -> frozenset[str]:
        """Return the names in a folder; cached, since most modules are in few folders."""
        if folder not in self._listed:
            try:
                self._listed[folder] = frozenset(each.name for each in folder.iterdir())
            except OSError:
                self._listed[folder] = frozenset()
        return self._listed[folder]

    def _module(self, file: Path) -> Module | None:
        source = read_source(file)
        if source.tree is None or _STUBS in source.text:
            return None
        self.sources.append(source)
        self._add_folders(source, file)
        return Module(source, source.tree)


def _folders(start: Path) -> Iterator[Path]:
    """Yield the folder and its parents, up to the repository's root."""
    folder = start.absolute()
    for _ in range(_MAX_FOLDERS):
        yield folder
        if (folder / ".git").exists() or folder.parent == folder:
            return
        folder = folder.parent


def definition(node: ast.stmt, module: Module) -> Value | None:
    """Return the class or function that a statement defines."""
    match node:
        case ast.ClassDef():
            return Class(node, module)
        case ast.FunctionDef():
            return Function(node, module)
    return None
