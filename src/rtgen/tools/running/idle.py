"""Finds the components of a system whose behaviours do nothing, or not what they seem to."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

from rtgen import runtime
from rtgen.compiler.diagnostics import Diagnostic
from rtgen.compiler.project import behaviour_callbacks, shown, skeletons
from rtgen.compiler.systems.rules import SKELETON


def findings(system: runtime.System) -> Iterator[Diagnostic]:
    """Yield diagnostics for the component types whose behaviour is a skeleton, or is never called.

    They are those of `rtgen check`, about modules of behaviours that a run has imported.
    """
    instances: dict[type, list[str]] = {}
    for instance in system.instances:
        class_ = type(system.component(instance))
        instances.setdefault(class_, []).append(instance)
    for class_, names in instances.items():
        module = sys.modules.get(class_.__module__)
        name = getattr(module, "__file__", None)
        text = None if name is None else skeletons.text_of(Path(name))
        if name is None or text is None:
            continue
        file = shown(Path(name))
        span = skeletons.place(text, file, class_.__name__)
        if span is not None:
            yield SKELETON.at(
                span,
                f"{', '.join(names)} {'do' if len(names) > 1 else 'does'} nothing: "
                "the behaviour is a skeleton",
                hint="write its callbacks; of a renamed component rtgen check finds the behaviour",
            )
        packages = {base.__module__.partition(".")[0] for base in class_.__mro__}
        yield from behaviour_callbacks.misspelt(packages, file, text)
