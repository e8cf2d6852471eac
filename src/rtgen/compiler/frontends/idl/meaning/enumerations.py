"""Lowers enums and bitmasks: values of their members, and annotations (OMG IDL 4.2)."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import msgspec

from rtgen.compiler.diagnostics import Diagnostic, Related, Rule, Span
from rtgen.compiler.frontends.idl.meaning.annotations import Annotations, flag, integer
from rtgen.compiler.frontends.idl.meaning.typetable import Types
from rtgen.compiler.frontends.idl.names.scopes import Entity
from rtgen.compiler.frontends.idl.rules import annotations as rules
from rtgen.compiler.frontends.idl.rules import syntax
from rtgen.compiler.frontends.idl.syntax import tree
from rtgen.compiler.frontends.idl.text.unit import Unit
from rtgen.compiler.model import Bitmask, Declaration, Enum, Enumerator

_DEFAULT_BOUND = 32


class Enumerations(msgspec.Struct, eq=False):
    """Lowers enums and bitmasks to the model; diagnostics go to `report`."""

    _types: Types
    _annotations: Annotations
    _report: Callable[[Diagnostic], None]

    def declaration(
        self,
        node: tree.Enum,
        entity: Entity,
        common: dict[str, Any],
        doc: Callable[[tree.Enumerator], str],
    ) -> Declaration | None:
        """Lower an enum or bitmask; None if it has an error."""
        unit = entity.unit
        good = self._written_well(node, unit, entity)
        bound = self._bound(node, common, entity)
        members: list[Enumerator] = []
        following = 0
        for member in node.members:
            place = "bit_value" if node.mask else "enumerator"
            attached = self._annotations.of(member.annotations, place, unit)
            number = integer(attached, "position" if node.mask else "value")
            span = unit.span(member.name.start, member.name.end)
            value = following if number is None else number
            good = self._number_fits(value, members, span, bound, node.mask) and good
            good = good and not self._types.tables.entities[member.name].poisoned
            members.append(
                Enumerator(
                    span=span,
                    doc=doc(member),
                    annotations=attached,
                    name=member.name.text,
                    value=value,
                )
            )
            following = value + 1
        self._default_is_one(members)
        if not good:
            return None
        if node.mask:
            return Bitmask(**common, members=tuple(members), bound=bound)
        return Enum(**common, members=tuple(members), bound=bound)

    def _written_well(self, node: tree.Enum, unit: Unit, entity: Entity) -> bool:
        good = True
        if not node.members:
            self._report(
                syntax.EMPTY_ENUM.at(
                    entity.span,
                    f"{entity.name} has no members",
                    hint="write at least one name between { and }",
                )
            )
            good = False
        if node.trailing is not None:
            span = unit.span(node.trailing, node.trailing + 1)
            self._report(
                syntax.TRAILING_COMMA.at(
                    span, "no comma after the last enumerator", hint="remove the ','"
                )
            )
            good = False
        for member in node.members:
            if member.value is not None and good:
                span = unit.span(member.value.start, member.value.end)
                self._report(
                    syntax.ENUMERATOR_VALUE.at(
                        span,
                        f"{member.name.text} cannot be given a value so",
                        hint=f"write @value(...) {member.name.text}",
                    )
                )
                good = False
        return good

    def _bound(self, node: tree.Enum, common: dict[str, Any], entity: Entity) -> int:
        bound = integer(common["annotations"], "bit_bound")
        if bound is None:
            return _DEFAULT_BOUND
        largest = 64 if node.mask else 32
        if not 1 <= bound <= largest:
            message = f"@bit_bound({bound}) is not from 1 to {largest}"
            hint = f"write a number from 1 to {largest}"
            self._report(rules.BAD_BIT_BOUND.at(entity.span, message, hint=hint))
            return _DEFAULT_BOUND
        return bound

    def _default_is_one(self, members: list[Enumerator]) -> None:
        defaults = [m for m in members if flag(m.annotations, "default_literal")]
        for member in defaults[1:]:
            self._report(
                rules.REPEATED.at(
                    member.span,
                    "@default_literal is given twice in one enum",
                    related=[Related(defaults[0].span, "the first time")],
                    hint="keep one of them",
                )
            )

    def _number_fits(
        self, value: int, before: list[Enumerator], span: Span, bound: int, mask: bool
    ) -> bool:
        rule: Rule = rules.BAD_BIT_BOUND if mask else rules.BAD_ENUM_VALUE
        if mask and not 0 <= value < bound:
            self._report(
                rule.at(
                    span,
                    f"the position {value} is not from 0 to {bound - 1}",
                    hint=f"@bit_bound gives the number of bits, here {bound}",
                )
            )
            return False
        if mask:
            for other in before:
                if other.value == value:
                    self._report(
                        rule.at(
                            span,
                            f"the position {value} is taken",
                            related=[Related(other.span, f"by {other.name}")],
                            hint="give each member a position of its own",
                        )
                    )
                    return False
            return True
        signed = value < 0 or (before and before[0].value < 0)
        lowest = before[-1].value + 1 if before else -(1 << (bound - 1))
        largest = (1 << (bound - 1 if signed else bound)) - 1
        if not lowest <= value <= largest:
            message = f"the value {value} is not from {lowest} to {largest}"
            related = (
                [Related(before[-1].span, f"{before[-1].name} is {before[-1].value}")]
                if before
                else []
            )
            hint = "values grow from one enumerator to the next"
            self._report(rule.at(span, message, related=related, hint=hint))
            return False
        return True
