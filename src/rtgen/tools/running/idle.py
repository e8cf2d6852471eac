"""Finds the components of a system whose behaviours are untouched skeletons."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

from rtgen import runtime
from rtgen.compiler.diagnostics import Diagnostic
from rtgen.compiler.project import shown, skeletons
from rtgen.compiler.systems.rules import SKELETON


def findings(system: runtime.System) -> Iterator[Diagnostic]:
    """Yield a diagnostic for each component type whose behaviour does nothing."""
    instances: dict[type, list[str]] = {}
    for instance in system.instances:
        class_ = type(system.component(instance))
        instances.setdefault(class_, []).append(instance)
    for class_, names in instances.items():
        module = sys.modules.get(class_.__module__)
        file = getattr(module, "__file__", None)
        if file is None:
            continue
        span = skeletons.place(Path(file), shown(Path(file)), class_.__name__)
        if span is not None:
            verb = "do" if len(names) > 1 else "does"
            yield SKELETON.at(
                span,
                f"{', '.join(names)} {verb} nothing: the behaviour is a skeleton",
                hint="write its callbacks; of a renamed component rtgen check finds the behaviour",
            )
