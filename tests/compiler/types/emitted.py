"""Emits packages from IDL into a folder and imports them."""

from __future__ import annotations

import importlib
import itertools
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from rtgen.compiler.backends import Options
from rtgen.compiler.backends.types.backend import BACKEND
from rtgen.compiler.diagnostics import has_errors
from rtgen.compiler.frontends.idl import load
from rtgen.compiler.lowering.numeric import lower
from rtgen.compiler.lowering.settings import Settings
from rtgen.facts.numeric import FORMS, Numeric

_numbers = itertools.count()


def emit(folder: Path, paths: Sequence[Path], numeric: Numeric = "array") -> ModuleType:
    """Return the generated package of the files, imported from below `folder`.

    `numeric` is the form of numbers, as `[python] numeric` sets it.
    """
    result = load(paths, root=paths[0].parent)
    assert not has_errors(result.diagnostics), result.diagnostics
    lowered = lower(result.model, Settings(numeric=numeric))
    assert not lowered.diagnostics
    package = f"emitted_{next(_numbers)}"
    emission = BACKEND.emit(lowered.model, Options(package, "skeletons", "0.0.0"))
    assert not emission.diagnostics
    for artifact in emission.artifacts:
        path = folder / artifact.path
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(artifact.text, encoding="utf-8")
    sys.path.insert(0, str(folder))
    try:
        importlib.invalidate_caches()
        module = importlib.import_module(package)
        for inner in sorted((folder / package / "_idl").glob("[a-z]*.py")):
            importlib.import_module(f"{package}._idl.{inner.stem}")
        for init in sorted((folder / package).rglob("__init__.py")):
            parts = init.parent.relative_to(folder).parts
            importlib.import_module(".".join(parts))
    finally:
        sys.path.remove(str(folder))
    return module


def emit_text(folder: Path, text: str, numeric: Numeric = "array") -> ModuleType:
    """Return the generated package of one IDL text."""
    path = folder / "case.idl"
    path.write_text(text, encoding="utf-8")
    return emit(folder, [path], numeric)


def in_each_form(
    factory: pytest.TempPathFactory, text: str
) -> dict[Numeric, ModuleType]:
    """Return the IDL module `n` of one text, generated with numbers in each form."""
    return {form: emit_text(factory.mktemp(form), text, form).n for form in FORMS}


def classes(package: ModuleType) -> Iterator[type[Any]]:
    """Yield the classes with descriptors that a package's modules define."""
    prefix = f"{package.__name__}._idl."
    for name in sorted(n for n in sys.modules if n.startswith(prefix)):
        for value in vars(sys.modules[name]).values():
            own = isinstance(value, type) and value.__module__ == name
            if own and hasattr(value, "_descriptor_"):
                yield value
