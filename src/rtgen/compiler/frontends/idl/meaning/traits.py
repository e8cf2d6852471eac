"""Extensibility and member ids from annotations (DDS-XTypes 1.3, 7.3.1.2).

Annotations of a module are defaults for its structs and unions.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from rtgen.compiler.frontends.idl.meaning.annotations import flag, integer, value
from rtgen.compiler.model import Annotation, Extensibility
from rtgen.facts.member_ids import hashed_id

_EXTENSIBILITIES = frozenset(e.value for e in Extensibility)
_GROUPS = dict.fromkeys(("extensibility", *_EXTENSIBILITIES), "extensibility")
_GROUPS |= {"nested": "nested", "topic": "nested", "default_nested": "nested"}
_GROUPS |= {name: name for name in ("autoid", "data_representation")}
"""Annotations that override those of modules, grouped by the property that they set."""


def extensibility(annotations: Sequence[Annotation]) -> Extensibility:
    """Return the extensibility by annotations: `@extensibility(X)` or `@X`; final by default."""
    for annotation in annotations:
        name = annotation.name
        if name == "extensibility":
            name = str(annotation.get()).lower()
        if name in _EXTENSIBILITIES:
            return Extensibility(name)
    return Extensibility.FINAL


def with_defaults(
    own: Sequence[Annotation], modules: Sequence[Sequence[Annotation]], derived: bool
) -> tuple[Annotation, ...]:
    """Return the annotations of a struct or union, with those inherited from its modules.

    A derived struct has the extensibility of its base.
    """
    groups = {_GROUPS.get(annotation.name) for annotation in own}
    if derived:
        groups.add("extensibility")
    annotations = list(own)
    for around in reversed(modules):
        new = [a for a in around if _GROUPS.get(a.name) not in (None, *groups)]
        groups |= {_GROUPS[annotation.name] for annotation in new}
        for annotation in new:
            is_default = annotation.name == "default_nested"
            annotations.append(
                Annotation("nested", annotation.arguments) if is_default else annotation
            )
    return tuple(annotations)


def of_type(annotations: Sequence[Annotation]) -> dict[str, Any]:
    """Return the fields of a struct or union that its annotations set."""
    return {
        "extensibility": extensibility(annotations),
        "nested": flag(annotations, "nested"),
    }


def hashes_ids(annotations: Sequence[Annotation]) -> bool:
    """Return whether member ids are hashes of the members' names (7.3.1.2.1.1)."""
    kind = value(annotations, "autoid")
    named = any(a.name == "autoid" for a in annotations)
    return named and (kind is None or str(kind).upper() == "HASH")


def member_id(name: str, annotations: Sequence[Annotation], hashed: bool) -> int | None:
    """Return the member id from `@id`, `@hashid` or `@autoid(HASH)`; None: sequential."""
    explicit = integer(annotations, "id")
    if explicit is not None:
        return explicit
    for annotation in annotations:
        if annotation.name == "hashid":
            return hashed_id(str(annotation.get() or name))
    return hashed_id(name) if hashed else None
