"""Pass over one expression: reads names declared before, returns an operand; adds nothing."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any, TypeAlias

from rtgen.compiler.diagnostics import Rule
from rtgen.compiler.frontends.cdl.names.entities import Place
from rtgen.compiler.frontends.cdl.names.operands import (
    NUMBERS,
    ExpressionError,
    Operand,
    OperandClass,
    operand_class_of,
)
from rtgen.compiler.frontends.cdl.names.scopes import Entity, Kind
from rtgen.compiler.frontends.cdl.names.table import Table
from rtgen.compiler.frontends.cdl.passes.arithmetic import (
    ARITHMETIC,
    COMPARISONS,
    OPERATORS,
    as_float,
    clipped,
    number_literal,
    operand_of,
    whole_number,
    wrapped,
)
from rtgen.compiler.frontends.cdl.passes.expression_walks import nesting_depth
from rtgen.compiler.frontends.cdl.rules import constants as rules
from rtgen.compiler.frontends.cdl.rules import syntax
from rtgen.compiler.frontends.cdl.syntax import tree
from rtgen.compiler.frontends.kit.suggestions import nearest
from rtgen.compiler.model.c_types import (
    BinaryExpression,
    CArrayType,
    CastExpression,
    ConditionalExpression,
    CPointerType,
    CStructType,
    CType,
    Expression,
    Literal,
    Reference,
    UnaryExpression,
    resolve,
)
from rtgen.compiler.model.tecs import TecsConst, TecsStruct

ReadType: TypeAlias = Callable[[tree.TypeName, Place], CType | None]
"""Function that reads the type of a cast; returns None, after a diagnostic, if it has errors."""

MAX_DEPTH = 100
"""Maximum nesting depth of operators whose value is not constant."""

_MAX_DIGITS = 1000

_MAX_BITS = 4096
"""Integers with more bits are not computed."""

_ESCAPES = {
    "n": 10, "t": 9, "r": 13, "0": 0, "a": 7, "b": 8, "f": 12, "v": 11,
}  # fmt: skip


class Expressions:
    """Analyses expressions in their scope."""

    def __init__(self, table: Table, read_type: ReadType) -> None:
        self.table = table
        self.read_type = read_type

    def operand(
        self,
        written: tree.Expression,
        place: Place,
        names: Mapping[str, CType] | None = None,
    ) -> Operand | None:
        """Return the operand of an expression; None, after a diagnostic, if it has errors.

        `names`: the parameters, members or attributes that it may use.
        """
        try:
            found = ExpressionAnalysis(self, place, names or {}).at(written)
        except ExpressionError:
            return None
        if nesting_depth(found.model) > MAX_DEPTH:
            message = f"this is nested for more than {MAX_DEPTH} levels"
            self.table.report(syntax.TOO_DEEP.at(place.span(written), message))
            return None
        return found

    def integer(self, written: tree.Expression, place: Place) -> int | None:
        """Return the value of a constant integer expression; None, after a diagnostic, without
        one.
        """
        found = self.operand(written, place)
        if found is None:
            return None
        if type(found.value) is not int:
            rule = rules.NOT_CONSTANT if found.value is None else rules.OPERATOR_KIND
            message = f"a constant integer is expected here, not {found.operand_class.with_article}"
            if found.value is None:
                message = "this is not constant"
            self.table.report(rule.at(place.span(written), message))
            return None
        return found.value

    def size(
        self, written: tree.SpecifierArgument, place: Place, names: Mapping[str, CType]
    ) -> Expression | None:
        """Return the model of a struct member's size; None, after a diagnostic, if invalid."""
        assert not isinstance(written, tree.Name | tree.Allocation | tree.Restriction)
        found = self.operand(written, place, names)
        if found is None:
            return None
        found = whole_number(found)
        if found.operand_class not in (OperandClass.INTEGER, OperandClass.UNKNOWN):
            message = f"a size is an integer, not {found.operand_class.with_article}"
            self.table.report(rules.OPERATOR_KIND.at(place.span(written), message))
            return None
        return found.model


class ExpressionAnalysis:
    """Analyses an expression and its operands."""

    def __init__(
        self, expressions: Expressions, place: Place, names: Mapping[str, CType]
    ) -> None:
        self._table = expressions.table
        self._read_type = expressions.read_type
        self._place = place
        self._names = names

    def error(
        self, rule: Rule, node: tree.Expression, message: str, hint: str | None = None
    ) -> ExpressionError:
        self._table.report(rule.at(self._place.span(node), message, hint=hint))
        return ExpressionError()

    def at(self, node: tree.Expression) -> Operand:
        """Return the operand of an expression. Raises ExpressionError."""
        match node:
            case tree.Number() if len(node.text) > _MAX_DIGITS:
                message = f"a number has at most {_MAX_DIGITS} digits"
                raise self.error(rules.RANGE, node, message)
            case tree.Number():
                return number_literal(node)
            case tree.Boolean():
                return Operand(OperandClass.BOOL, node.value, Literal(node.value))
            case tree.Character():
                return self._character(node)
            case tree.Text():
                return Operand(OperandClass.STRING, node.text, Literal(node.text))
            case tree.ScopedName():
                return self._name(node)
            case tree.Group():
                return self.at(node.inner)
            case tree.Unary():
                return self._unary(node)
            case tree.Cast():
                return self._cast(node)
            case tree.Chain():
                return self._chain(node)
            case tree.Postfix():
                return self._postfix(node)
            case tree.Conditional():
                return self._conditional(node)

    def _character(self, node: tree.Character) -> Operand:
        text = node.text or " "  # empty after a reported error
        value = ord(text) if len(text) == 1 else _ESCAPES.get(text[1], ord(text[1]))
        return Operand(OperandClass.INTEGER, value, Literal(value))

    def _name(self, node: tree.ScopedName) -> Operand:
        if len(node.parts) == 1 and not node.absolute:
            name = node.parts[0].text
            type_ = self._names.get(name)
            if type_ is not None:
                return Operand(operand_class_of(type_), None, Reference(name), type_)
        found = self._place.scope.find(node)
        if isinstance(found, Entity) and found.kind is Kind.CONSTANT:
            declaration = found.declaration
            if not isinstance(declaration, TecsConst):
                raise ExpressionError  # reported at its declaration
            value = declaration.value
            model = Reference("_".join(found.name)) if value is None else Literal(value)
            class_ = operand_class_of(declaration.type)
            own = found.value
            if own is not None and class_ in NUMBERS and own.operand_class in NUMBERS:
                # tecsgen replaces the name by the value as written.
                return Operand(own.operand_class, own.value, model, declaration.type)
            return Operand(class_, value, model, declaration.type)
        if node.parts[-1].text in self._place.unit.maybe_declared:
            raise ExpressionError
        if found is not None:
            what = found.kind
            raise self.error(
                rules.UNKNOWN_NAME, node, f"'{node}' is a {what}, no value"
            )
        near = self._table.guesses.nearest(
            str(node), [*self._names, *self._place.scope.visible()]
        )
        hint = f"did you mean '{near}'?" if near else None
        raise self.error(rules.UNKNOWN_NAME, node, f"'{node}' is unknown here", hint)

    def _unary(self, node: tree.Unary) -> Operand:
        operand = self.at(node.operand)
        if node.operator == "&":
            message = "an address has no value before the program runs"
            raise self.error(rules.CANNOT_EVALUATE, node, message)
        if node.operator == "*":
            return self._target(node, operand)
        model = UnaryExpression(node.operator, operand.model)
        if operand.operand_class is OperandClass.UNKNOWN:
            return Operand(OperandClass.UNKNOWN, None, model)
        if node.operator == "!":
            value = self._boolean_of(node.operand, operand)
            negated = None if value is None else not value
            return operand_of(OperandClass.BOOL, negated, model)
        wanted = (
            (OperandClass.INTEGER,)
            if node.operator == "~"
            else (OperandClass.INTEGER, OperandClass.FLOAT)
        )
        if operand.operand_class not in wanted:
            raise self._unfit(node, node.operator, operand)
        value_: Any = operand.value
        if value_ is not None:
            value_ = ~value_ if node.operator == "~" else value_
            value_ = -value_ if node.operator == "-" else value_
        return operand_of(operand.operand_class, value_, model)

    def _target(self, node: tree.Unary, operand: Operand) -> Operand:
        model = UnaryExpression("*", operand.model)
        if operand.operand_class is OperandClass.UNKNOWN:
            return Operand(OperandClass.UNKNOWN, None, model)
        if operand.operand_class is not OperandClass.POINTER or operand.type is None:
            raise self._unfit(node, "*", operand)
        found = resolve(operand.type)
        assert isinstance(found, CPointerType | CArrayType)
        target = found.target if isinstance(found, CPointerType) else found.element
        if operand.value is not None or isinstance(operand.model, Literal):
            message = "the target of a pointer has no value before the program runs"
            raise self.error(rules.CANNOT_EVALUATE, node, message)
        return Operand(operand_class_of(target), None, model, target)

    def _postfix(self, node: tree.Postfix) -> Operand:
        operand = self.at(node.operand)
        for suffix in node.suffixes:
            if isinstance(suffix, tree.Name):
                operand = self._member(node, operand, suffix)
            else:
                operand = self._element(node, operand, suffix)
        return operand

    def _member(self, node: tree.Postfix, operand: Operand, name: tree.Name) -> Operand:
        model = BinaryExpression(".", operand.model, Reference(name.text))
        found = resolve(operand.type) if operand.type is not None else None
        if not isinstance(found, CStructType):
            message = f"'.{name.text}' has no value before the program runs"
            raise self.error(rules.CANNOT_EVALUATE, node, message)
        entity = self._table.tag(found.tag)
        if entity is None or not isinstance(entity.declaration, TecsStruct):
            return Operand(OperandClass.UNKNOWN, None, model)
        for member in entity.declaration.members:
            if member.name == name.text:
                return Operand(operand_class_of(member.type), None, model, member.type)
        near = nearest(name.text, [m.name for m in entity.declaration.members])
        raise self.error(
            rules.UNKNOWN_NAME,
            node,
            f"{found} has no member '{name.text}'",
            f"did you mean '{near}'?" if near else None,
        )

    def _element(
        self, node: tree.Postfix, operand: Operand, subscript: tree.Subscript
    ) -> Operand:
        assert subscript.index is not None
        index = self.at(subscript.index)
        model = BinaryExpression("[]", operand.model, index.model)
        if operand.operand_class is OperandClass.UNKNOWN:
            return Operand(OperandClass.UNKNOWN, None, model)
        found = resolve(operand.type) if operand.type is not None else None
        if (
            not isinstance(found, CPointerType | CArrayType)
            or operand.value is not None
        ):
            message = "a subscript has no value before the program runs"
            raise self.error(rules.CANNOT_EVALUATE, node, message)
        if index.operand_class not in (OperandClass.INTEGER, OperandClass.UNKNOWN):
            raise self._unfit(subscript.index, "[]", index)
        target = found.target if isinstance(found, CPointerType) else found.element
        return Operand(operand_class_of(target), None, model, target)

    def _cast(self, node: tree.Cast) -> Operand:
        operand = self.at(node.operand)
        type_ = self._read_type(node.type, self._place)
        if type_ is None:
            raise ExpressionError
        class_ = operand_class_of(type_)
        model = CastExpression(type_, operand.model)
        numbers = (
            OperandClass.BOOL,
            OperandClass.INTEGER,
            OperandClass.FLOAT,
            OperandClass.UNKNOWN,
        )
        fits = (
            operand.operand_class is OperandClass.UNKNOWN
            or (
                class_ is OperandClass.BOOL
                and operand.operand_class in (OperandClass.BOOL, OperandClass.INTEGER)
            )
            or (
                class_ in numbers
                and class_ is not OperandClass.BOOL
                and operand.operand_class in numbers
            )
            or (
                class_ is OperandClass.INTEGER
                and operand.operand_class is OperandClass.POINTER
            )
            or (
                class_ is OperandClass.POINTER
                and operand.operand_class
                in (OperandClass.INTEGER, OperandClass.POINTER)
            )
        )
        if not fits:
            message = f"{operand.operand_class.with_article} cannot be cast to {type_}"
            raise self.error(rules.OPERATOR_KIND, node, message)
        value = operand.value
        if value is None or class_ is OperandClass.POINTER:
            return Operand(
                class_, value if class_ is OperandClass.POINTER else None, model, type_
            )
        if class_ is OperandClass.BOOL:
            return Operand(class_, bool(value), Literal(bool(value)), type_)
        if class_ is OperandClass.FLOAT and not isinstance(value, str):
            return operand_of(class_, as_float(value), model, type_)
        if class_ is OperandClass.INTEGER and not isinstance(value, str):
            if isinstance(value, float):
                return operand_of(class_, clipped(value, type_), model, type_)
            return operand_of(class_, wrapped(int(value), type_), model, type_)
        return Operand(class_, None, model, type_)

    def _conditional(self, node: tree.Conditional) -> Operand:
        condition = self.at(node.condition)
        yes, no = self.at(node.yes), self.at(node.no)
        truth = self._boolean_of(node.condition, condition)
        if truth is not None:
            return yes if truth else no
        model = ConditionalExpression(condition.model, yes.model, no.model)
        class_ = (
            OperandClass.FLOAT
            if OperandClass.FLOAT in (yes.operand_class, no.operand_class)
            else yes.operand_class
        )
        return Operand(class_, None, model, yes.type)

    def _boolean_of(self, node: tree.Expression, operand: Operand) -> bool | None:
        """Return the boolean value of an operand; None if not constant. Raises ExpressionError."""
        if operand.operand_class not in (
            OperandClass.BOOL,
            OperandClass.INTEGER,
            OperandClass.UNKNOWN,
        ):
            raise self.error(
                rules.OPERATOR_KIND,
                node,
                f"a truth value is expected here, not a {operand.operand_class}",
                "compare it, or cast it",
            )
        return None if operand.value is None else bool(operand.value)

    def _chain(self, node: tree.Chain) -> Operand:
        left = self.at(node.first)
        for mark, written in node.rest:
            left = self._binary(node, mark, left, self.at(written), written)
        return left

    def _binary(
        self,
        node: tree.Chain,
        mark: str,
        left: Operand,
        right: Operand,
        written: tree.Expression,
    ) -> Operand:
        model = BinaryExpression(mark, left.model, right.model)
        if mark in ("&&", "||"):
            one, two = self._boolean_of(node.first, left), self._boolean_of(
                written, right
            )
            if one is None or two is None:
                return Operand(OperandClass.BOOL, None, model)
            truth = (one and two) if mark == "&&" else (one or two)
            return operand_of(OperandClass.BOOL, truth, model)
        if OperandClass.UNKNOWN in (left.operand_class, right.operand_class):
            return Operand(OperandClass.UNKNOWN, None, model)
        if (
            left.operand_class in ARITHMETIC
            and right.operand_class is OperandClass.BOOL
        ):
            # tecsgen uses 0 or 1 for a boolean to the right of a number.
            number = None if right.value is None else int(right.value)
            right = Operand(OperandClass.INTEGER, number, right.model)
        if mark in COMPARISONS:
            return self._comparison(node, mark, left, right, model)
        if mark in ("+", "-") and OperandClass.POINTER in (
            left.operand_class,
            right.operand_class,
        ):
            if (
                OperandClass.FLOAT in (left.operand_class, right.operand_class)
                or left.value is not None
            ):
                raise self._unfit(node, mark, right)
            return Operand(OperandClass.POINTER, None, model, left.type or right.type)
        wanted = ARITHMETIC if mark in "+-*/%" else (OperandClass.INTEGER,)
        for operand in (left, right):
            if operand.operand_class not in wanted:
                raise self._unfit(node, mark, operand)
        if mark in ("/", "%") and right.value == 0 and right.value is not None:
            raise self.error(rules.DIVISION, written, "this is zero")
        class_ = (
            OperandClass.FLOAT
            if OperandClass.FLOAT in (left.operand_class, right.operand_class)
            else OperandClass.INTEGER
        )
        if left.value is None or right.value is None:
            return Operand(class_, None, model)
        return operand_of(
            class_, self._computed(node, mark, left.value, right.value), model
        )

    def _computed(self, node: tree.Chain, mark: str, one: Any, two: Any) -> Any:
        if mark in ("<<", ">>") and not 0 <= two < _MAX_BITS:
            message = f"a shift by {two} has no value"
            raise self.error(rules.OPERATOR_KIND, node, message)
        try:
            if mark == "/" and isinstance(one, int) and isinstance(two, int):
                return one // two
            value = OPERATORS[mark](one, two)
        except OverflowError:
            value = math.inf
        if isinstance(value, int) and value.bit_length() > _MAX_BITS:
            raise self.error(
                rules.RANGE, node, "this value is too large to be computed"
            )
        return value

    def _comparison(
        self,
        node: tree.Chain,
        mark: str,
        left: Operand,
        right: Operand,
        model: Expression,
    ) -> Operand:
        numbers = (OperandClass.INTEGER, OperandClass.FLOAT)
        fits = (left.operand_class in numbers and right.operand_class in numbers) or (
            left.operand_class is right.operand_class is OperandClass.BOOL
            and mark in ("==", "!=")
        )
        if not fits:
            one, two = left.operand_class.with_article, right.operand_class.with_article
            message = f"'{mark}' does not compare {one} with {two}"
            raise self.error(rules.OPERATOR_KIND, node, message)
        if left.value is None or right.value is None:
            return Operand(OperandClass.BOOL, None, model)
        return operand_of(
            OperandClass.BOOL, COMPARISONS[mark](left.value, right.value), model
        )

    def _unfit(
        self, node: tree.Expression, mark: str, operand: Operand
    ) -> ExpressionError:
        message = f"'{mark}' cannot be used on {operand.operand_class.with_article}"
        return self.error(rules.OPERATOR_KIND, node, message)
