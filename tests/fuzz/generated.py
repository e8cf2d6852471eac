"""Generated Python of all back ends, imported from memory."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from importlib.abc import InspectLoader, MetaPathFinder
from importlib.machinery import ModuleSpec
from itertools import chain
from pathlib import Path
from types import ModuleType

from fuzzing import ViolationError

from rtgen.compiler.backends import Options
from rtgen.compiler.backends.stage import BUILT_IN, together
from rtgen.compiler.diagnostics import InputError, has_errors
from rtgen.compiler.model import Model
from rtgen.runtime.marshalling import descriptors


def generate(model: Model) -> dict[str, str]:
    """Return the Python of all back ends by its paths. Raises InputError for errors."""
    options = Options("fuzzed", "skeletons", "0")
    emission = together(backend.emit(model, options) for backend in BUILT_IN)
    diagnostics = emission.diagnostics
    for d in diagnostics:
        if d.span is None or not d.message:
            raise ViolationError(f"{d.code} of a back end is nowhere")
    if has_errors(diagnostics):
        raise InputError(diagnostics)
    texts: dict[str, str] = {}
    for artifact in emission.artifacts:
        if artifact.path.endswith(".py"):
            compile(artifact.text, artifact.path, "exec", dont_inherit=True)
            if artifact.path.startswith("fuzzed/"):
                texts[artifact.path] = artifact.text
    return texts


@contextmanager
def forgotten_types() -> Iterator[None]:
    """Remove the types that are imported meanwhile from the runtime's registries and caches."""
    before = dict(descriptors._REGISTERED)
    try:
        yield
    finally:
        descriptors._REGISTERED.clear()
        descriptors._REGISTERED.update(before)
        for name in [n for n in sys.modules if n.startswith("rtgen.runtime.")]:
            for value in vars(sys.modules[name]).values():
                if clear := getattr(value, "cache_clear", None):
                    clear()


class Generated(MetaPathFinder, InspectLoader):
    """Generated Python that is imported from memory; `texts` maps paths to texts."""

    def __init__(self, texts: dict[str, str]) -> None:
        self._texts = {_module(path): text for path, text in texts.items()}
        parents = (Path(path).parents for path in texts)
        self._packages = {p.as_posix().replace("/", ".") for p in chain(*parents)}

    def load(self) -> dict[str, ModuleType]:
        """Import all modules, remove them from `sys.modules`, and return them by their names."""
        before = set(sys.modules)
        sys.meta_path.insert(0, self)
        try:
            for name in self._texts:
                importlib.import_module(name)
            return {name: sys.modules[name] for name in self._texts}
        finally:
            sys.meta_path.remove(self)
            for name in set(sys.modules) - before:
                if name in self._texts or name in self._packages:
                    del sys.modules[name]

    def find_spec(
        self,
        fullname: str,
        path: Sequence[str] | None,
        target: ModuleType | None = None,
    ) -> ModuleSpec | None:
        """Return the spec of a generated module."""
        if fullname not in self._texts and fullname not in self._packages:
            return None
        return ModuleSpec(fullname, self, is_package=fullname in self._packages)

    def is_package(self, fullname: str) -> bool:
        """Return whether a module is a package."""
        return fullname in self._packages

    def get_source(self, fullname: str) -> str:
        """Return the text of a module."""
        return self._texts.get(fullname, "")


def _module(path: str) -> str:
    return path.removesuffix(".py").removesuffix("/__init__").replace("/", ".")
