"""Types, constants and initialisers for the passes over celltypes and cells; adds nothing."""

from __future__ import annotations

from collections.abc import Mapping

from rtgen.compiler.diagnostics import Rule
from rtgen.compiler.frontends.cdl.names.entities import Declared, Names, Place
from rtgen.compiler.frontends.cdl.names.operands import ExpressionError, Operand
from rtgen.compiler.frontends.cdl.names.table import Table
from rtgen.compiler.frontends.cdl.passes.constants import Constants
from rtgen.compiler.frontends.cdl.passes.expressions import (
    ExpressionAnalysis,
    Expressions,
)
from rtgen.compiler.frontends.cdl.passes.types import Types
from rtgen.compiler.frontends.cdl.passes.untagged import name_of_untagged
from rtgen.compiler.frontends.cdl.syntax import tree
from rtgen.compiler.model.c_types import CType, Expression

_MAX_NESTED = 20
"""Maximum depth of attributes whose values refer to one another."""


class DeclaredValues:
    """Types, constants and initialisers of a unit for the passes over components."""

    def __init__(self, table: Table, types: Types, constants: Constants) -> None:
        self._table = table
        self._types = types
        self._constants = constants

    @property
    def incomplete(self) -> bool:
        """Whether an import is missing, so that unknown names may be declared there."""
        return self._table.incomplete

    def declare(self, declaration: tree.Declaration, place: Place) -> list[Declared]:
        """Return the names declared by attributes or variables; reports errors."""
        types, place = self._types, place
        untagged = name_of_untagged(part.declarator for part in declaration.declarators)
        base = types.of(declaration.type, place, untagged)
        found = []
        for part in declaration.declarators:
            name = part.declarator.name
            assert name is not None
            type_ = types.declared(base, part.declarator, place)
            if type_ is not None and not types.is_value(type_, place, name):
                type_ = None
            found.append(Declared(name, type_, part.value))
        return found

    def constant(
        self, expression: tree.Expression, place: Place, names: Names | None = None
    ) -> object:
        """Return the value of a constant expression; None, without a diagnostic, if it has none."""
        try:
            return (
                _Quiet(self._types.expressions, place, names, _MAX_NESTED)
                .at(expression)
                .value
            )
        except ExpressionError:
            return None

    def initial(
        self,
        type_: CType,
        value: tree.Initialiser,
        place: Place,
        types: Mapping[str, CType],
    ) -> Expression | None:
        """Return the model of an initialiser of the type; None if it does not fit."""
        return self._constants.initial(value, type_, place, types)

    def expression(
        self, expression: tree.Expression, place: Place, types: Mapping[str, CType]
    ) -> Expression | None:
        """Return the model of an expression; None, after a diagnostic, if it has errors."""
        found = self._types.expressions.operand(expression, place, types)
        return None if found is None else found.model


class _Quiet(ExpressionAnalysis):
    """Evaluates without diagnostics, replacing attributes by their values."""

    def __init__(
        self, expressions: Expressions, place: Place, values: Names | None, depth: int
    ) -> None:
        super().__init__(expressions, place, {})
        self._expressions = expressions
        self._values = values
        self._depth = depth

    def error(
        self, rule: Rule, node: tree.Expression, message: str, hint: str | None = None
    ) -> ExpressionError:
        return ExpressionError()

    def at(self, node: tree.Expression) -> Operand:
        if isinstance(node, tree.ScopedName) and self._values is not None:
            found = self._values(node.parts[0].text) if len(node.parts) == 1 else None
            if found is not None:
                value, place = found
                if self._depth == 0 or isinstance(value, tree.CExp | tree.Aggregate):
                    raise ExpressionError
                deeper = _Quiet(self._expressions, place, self._values, self._depth - 1)
                return deeper.at(value)
        return super().at(node)
