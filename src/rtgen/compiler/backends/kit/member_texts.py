"""Comments for readers of generated files, with the units and limits of annotations."""

from __future__ import annotations

from rtgen.compiler.backends.kit.idl_text.literals import default_text
from rtgen.compiler.model import Documented, Limits, Operation, limits
from rtgen.compiler.typemap.member_units import annotated_unit, unit_in
from rtgen.facts.comments import split_sentence


def member_text(entry: Documented, otherwise: str = "") -> str:
    """Return the comment of a member or declaration, with its unit and limits.

    `otherwise` replaces a blank comment, if there is a unit or a limit.
    """
    unit, bounds = annotated_unit(entry), limits_text(limits(entry.annotations))
    if unit is None and not bounds:
        return entry.doc
    text = entry.doc if entry.doc.strip() else otherwise
    if unit is not None and unit != unit_in(entry.doc):
        text = _with_unit(text, unit)
        if unit_in(text) != unit:
            text = f"{entry.doc.strip()}\n[{unit}]"
    if not bounds:
        return text
    sentence = f"{bounds[0].upper()}{bounds[1:]}."
    text = text.strip()
    if text and "\n" not in text and text[-1] not in ".!?":
        text += "."
    return f"{text}\n\n{sentence}" if text else sentence


def limits_text(within: Limits) -> str:
    """Return limits for readers: `at least 0.0, at most 1.0`."""
    return ", ".join(
        f"{word} {default_text(value)}"
        for word, value in zip(("at least", "at most"), within, strict=True)
        if value is not None
    )


def operation_text(operation: Operation) -> str:
    """Return the comment of an operation, and a line for each parameter with one of its own."""
    described = [
        f"{p.name}: {text}"
        for p in operation.parameters
        if (p.doc or p.annotations) and (text := " ".join(member_text(p).split()))
    ]
    parts = (operation.doc.strip(), "\n".join(described))
    return "\n\n".join(filter(None, parts)) if described else operation.doc


def _with_unit(doc: str, unit: str) -> str:
    """Return a comment with the unit in its first sentence, before the full stop."""
    first, rest = split_sentence(doc)
    if unit:
        stop = "." if first.endswith(".") else ""
        first = f"{first.removesuffix('.')} [{unit}]{stop}".strip()
    return first + rest
