"""Data representations of types (DDS-XTypes 1.3), by annotations and defaults."""

from __future__ import annotations

from rtgen.compiler.model import (
    ArrayType,
    Extensibility,
    FixedType,
    Interface,
    MapType,
    Model,
    NamedType,
    Native,
    Primitive,
    PrimitiveType,
    ScopedName,
    SequenceType,
    Struct,
    Type,
    Union,
    ValueBox,
    Valuetype,
)

_NOT_IN_XCDR = frozenset(
    (Primitive.ANY, Primitive.OBJECT, Primitive.TYPE_CODE, Primitive.VALUE_BASE)
)
_EXTENSIBILITIES = frozenset(("extensibility", *Extensibility))
"""The annotations that define an extensibility."""


class Representations:
    """Extensibility and representation of the structs and unions of a model.

    `@data_representation(XCDR2)` selects XCDR2, `XCDR` classic CDR, or XCDR1 for types that
    classic CDR cannot represent.
    """

    def __init__(
        self, model: Model, xcdr2: bool = False, extensibility: str = "final"
    ) -> None:
        self._model = model
        self.are_xcdr2 = xcdr2
        """Whether typedefs are XCDR2."""
        self._extensibility = Extensibility(extensibility)
        self._names = {d.name for d in model.declarations}

    def extensibility(self, declaration: Struct | Union) -> Extensibility:
        """Return a struct's or union's extensibility: annotated, the base's, or the default."""
        annotations = declaration.annotations
        written = annotations and any(a.name in _EXTENSIBILITIES for a in annotations)
        if written or declaration.name not in self._names:
            return declaration.extensibility
        if isinstance(declaration, Struct) and declaration.base is not None:
            base = self._model.find(declaration.base)
            assert isinstance(base, Struct)
            return self.extensibility(base)
        return self._extensibility

    def is_xcdr2(self, declaration: Struct | Union) -> bool:
        """Return whether `to_cdr` returns XCDR2; False for types outside of the model."""
        annotation = declaration.annotation("data_representation")
        if annotation is not None:
            value = annotation.get() or annotation.get("allowed_kinds")
            word = str(value).upper().rpartition("::")[2]
            if word in ("XCDR", "XCDR1", "XCDR2"):
                return word == "XCDR2"
        return self.are_xcdr2 and declaration.name in self._names

    def missing(self, type_: Type) -> str | None:
        """Return the part of the type that XCDR cannot represent; None if there is none."""
        return self._missing(type_, set())

    def _missing(self, type_: Type, seen: set[ScopedName]) -> str | None:
        type_ = self._model.unalias(type_)
        match type_:
            case PrimitiveType(kind) if kind in _NOT_IN_XCDR:
                return str(kind)
            case FixedType():
                return str(type_)
            case SequenceType(element) | ArrayType(element):
                return self._missing(element, seen)
            case MapType(key, value):
                return self._missing(key, seen) or self._missing(value, seen)
            case NamedType(name) if name not in seen:
                seen.add(name)
                declaration = self._model.find(name)
                if isinstance(declaration, Interface | Native | Valuetype | ValueBox):
                    return declaration.scoped
                if isinstance(declaration, Struct | Union):
                    types = member_types(declaration)
                    inner = (self._missing(part, seen) for part in types)
                    return next((text for text in inner if text is not None), None)
        return None


def member_types(declaration: Struct | Union) -> list[Type]:
    """Return the types of the members and the base, or of the branches."""
    if isinstance(declaration, Union):
        return [case.type for case in declaration.cases]
    types = [member.type for member in declaration.members]
    return types + ([NamedType(declaration.base)] if declaration.base else [])
