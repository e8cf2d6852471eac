"""Checks of structs, exceptions, bitsets, typedefs, constants and repository ids."""

from __future__ import annotations

from rtgen.compiler.diagnostics import Related
from rtgen.compiler.frontends.idl.meaning.checks.context import Context
from rtgen.compiler.frontends.idl.names.scopes import Entity
from rtgen.compiler.frontends.idl.rules import annotations as annotation_rules
from rtgen.compiler.frontends.idl.rules import repository as repository_rules
from rtgen.compiler.frontends.idl.rules import types as rules
from rtgen.compiler.frontends.idl.syntax import tree
from rtgen.compiler.model import (
    Bitset,
    Case,
    Declaration,
    Member,
    Primitive,
    PrimitiveType,
    Struct,
    Union,
)
from rtgen.facts.primitives import INTEGER_RANGES

_WIDTH = {
    kind: max(high.bit_length(), (-low - 1).bit_length() + 1 if low else 0)
    for kind, (low, high) in INTEGER_RANGES.items()
}
_EXTENSIBILITIES = ("final", "appendable", "mutable")
_MAX_BITS = 64
_MAX_BASES = 64
_MAX_MEMBER_ID = 2**28 - 1


def members(entity: Entity, context: Context) -> None:
    """Check that members have data types."""
    assert isinstance(entity.node, tree.Struct)
    for item in entity.node.body.items:
        if isinstance(item.node, tree.Member):
            context.is_data(item.node.type, entity.unit)


def annotated(entity: Entity, context: Context) -> None:
    """Check that `@key`, `@optional` and extensibility are compatible."""
    declaration = context.made.get(entity.path)
    if declaration is None or not entity.item:
        return
    kinds = [a.name for a in declaration.annotations if a.name in _EXTENSIBILITIES]
    for annotation in declaration.annotations:
        if annotation.name == "extensibility":
            kinds.append(str(annotation.get()).lower())
    if len(set(kinds)) > 1:
        message = f"{entity.name} cannot be {' and '.join(dict.fromkeys(kinds))}"
        hint = "keep one of the annotations"
        context.report(
            annotation_rules.EXTENSIBILITY.at(entity.span, message, hint=hint)
        )
    if isinstance(declaration, Struct):
        _member_annotations(declaration, context)


def _member_annotations(declaration: Struct, context: Context) -> None:
    for member in declaration.members:
        if not member.annotations:
            continue
        if member.key and member.optional:
            message = f"{member.name} is a key, so it cannot be optional"
            hint = "remove @key or @optional"
            context.report(
                annotation_rules.KEY_OPTIONAL.at(member.span, message, hint=hint)
            )


def member_ids(entity: Entity, context: Context) -> None:
    """Check that member ids, explicit or sequential, are unique."""
    declaration = context.made.get(entity.path)
    entries: list[Member | Case] = []
    if isinstance(declaration, Union):
        entries += declaration.cases
    base: Declaration | None = declaration
    for _ in range(_MAX_BASES):
        if not isinstance(base, Struct):
            break
        entries[:0] = base.members
        base = context.made.get(base.base) if base.base else None
    own = getattr(declaration, "members", entries)
    taken: dict[int, Member | Case] = {}
    following = 1 if isinstance(declaration, Union) else 0
    for entry in entries:
        number = following if entry.id is None else entry.id
        following = number + 1
        other = taken.setdefault(number, entry)
        if not 0 <= number <= _MAX_MEMBER_ID:
            message = f"the id {number} is not from 0 to {_MAX_MEMBER_ID}"
            context.report(annotation_rules.BAD_ARGUMENT.at(entry.span, message))
        elif other is not entry and entry in own:
            context.report(
                annotation_rules.DUPLICATE_ID.at(
                    entry.span,
                    f"the id {number} is taken",
                    related=[Related(other.span, f"by {other.name}")],
                    hint="give each member an id of its own",
                )
            )


def typedef(entity: Entity, context: Context) -> None:
    """Check that a typedef names a data type."""
    if entity.type_node is not None:
        context.is_data(entity.type_node, entity.unit)


def constant(entity: Entity, context: Context) -> None:
    """Check that constants of this type exist (invalid values are reported by `constants`)."""
    assert isinstance(entity.node, tree.Const)
    type_ = entity.node.type
    if isinstance(type_, tree.Fixed) and type_.digits is not None:
        message = "the digits of a fixed-point constant are those of its value"
        hint = "write fixed, or give the type a name by a typedef"
        context.report_at(rules.BAD_FIXED, entity.unit, type_, message, hint=hint)
    if context.types.of_node(entity.node.type, entity.unit) is None:
        entity.poisoned = True


def bitset(entity: Entity, context: Context) -> None:
    """Check that bit fields fit their types, and together into 64 bits."""
    declaration = context.made.get(entity.path)
    if not isinstance(declaration, Bitset):
        return
    total = _bits(declaration, context)
    if total > _MAX_BITS:
        message = f"{entity.name} has {total} bits, more than {_MAX_BITS}"
        hint = "split it into several bitsets"
        context.report(rules.BAD_BITFIELD.at(entity.span, message, hint=hint))
    for field in declaration.members:
        most = _MAX_BITS
        if field.type is not None:
            plain = context.types.unaliased(field.type)
            kind = plain.kind if isinstance(plain, PrimitiveType) else None
            width = (
                1 if kind is Primitive.BOOLEAN else _WIDTH.get(kind) if kind else None
            )
            if width is None:
                message = f"{field.type} is not a type for a bit field"
                hint = "it is an integer, octet or boolean type"
                context.report(rules.BAD_BITFIELD.at(field.span, message, hint=hint))
                continue
            most = width
        if field.bits > most:
            message = f"{field.bits} bits do not fit into {most}"
            hint = f"write {most} at most, or a larger type"
            context.report(rules.BAD_BITFIELD.at(field.span, message, hint=hint))


def _bits(declaration: Bitset, context: Context) -> int:
    total = 0
    current: Bitset | None = declaration
    while current is not None and total <= _MAX_BITS * 2:
        total += sum(field.bits for field in current.members)
        base = context.made.get(current.base) if current.base else None
        current = base if isinstance(base, Bitset) else None
    return total


def repository_id(entity: Entity, ids: dict[str, Entity], context: Context) -> None:
    """Check that repository ids are unique."""
    other = ids.setdefault(entity.repository_id, entity)
    if other is not entity and not entity.poisoned and not other.poisoned:
        context.report(
            repository_rules.SAME_ID.at(
                entity.span,
                f"{entity.scoped} and {other.scoped} have one repository id,"
                f" {entity.repository_id}",
                related=[Related(other.span, f"{other.scoped} is declared here")],
                hint="give each its own, by #pragma ID or another prefix",
            )
        )
