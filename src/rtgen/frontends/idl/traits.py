"""What annotations say of a type and its members: extensibility, member ids (DDS-XTypes 1.3)."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from typing import Any

from rtgen.frontends.idl.annotations import flag, integer, value
from rtgen.model import Annotation, Extensibility

_MEMBER_ID = 0x0FFFFFFF
_EXTENSIBILITIES = frozenset(e.value for e in Extensibility)


def extensibility(annotations: Sequence[Annotation]) -> Extensibility:
    """What `@final`, `@appendable`, `@mutable` or `@extensibility` says; final by default."""
    for annotation in annotations:
        name = annotation.name
        if name == "extensibility":
            name = str(annotation.get()).lower()
        if name in _EXTENSIBILITIES:
            return Extensibility(name)
    return Extensibility.FINAL


def of_type(annotations: Sequence[Annotation]) -> dict[str, Any]:
    """The fields of a struct or union that its annotations give."""
    return {
        "extensibility": extensibility(annotations),
        "nested": flag(annotations, "nested"),
    }


def hashes_ids(annotations: Sequence[Annotation]) -> bool:
    """Whether the members of the type have hashes of their names for ids (7.3.1.2.1.1)."""
    found = value(annotations, "autoid")
    named = any(a.name == "autoid" for a in annotations)
    return named and (found is None or str(found).upper() == "HASH")


def member_id(name: str, annotations: Sequence[Annotation], hashed: bool) -> int | None:
    """The id that `@id` or `@hashid` gives a member, or `@autoid(HASH)` all; None: in order."""
    given = integer(annotations, "id")
    if given is not None:
        return given
    for annotation in annotations:
        if annotation.name == "hashid":
            return hashed_id(str(annotation.get() or name))
    return hashed_id(name) if hashed else None


def hashed_id(name: str) -> int:
    """The id that stands for a name (7.3.1.2.1.1): 28 bits of its MD5, least significant first."""
    digest = hashlib.md5(name.encode(), usedforsecurity=False).digest()
    return int.from_bytes(digest[:4], "little") & _MEMBER_ID
