"""Evaluates constant expressions (CORBA 2.6, 3.10.2; OMG IDL 4.2, 7.4.1.4.3) for a target type."""

from __future__ import annotations

import struct
from collections.abc import Callable
from decimal import ROUND_DOWN, Decimal
from math import copysign, inf, isfinite

from rtgen.compiler.diagnostics import Diagnostic, Related, Rule
from rtgen.compiler.frontends.idl.meaning.operands import (
    BOUND_HINT,
    CONVERSIONS,
    DIGITS_31,
    EXACT,
    EXAMPLES,
    FLOATS,
    LARGEST_DOUBLE,
    LARGEST_FLOAT,
    NARROW,
    WIDE,
    OperandClass,
    brief,
    is_literal,
    operand_class_of,
    wider,
    without_zeros,
)
from rtgen.compiler.frontends.idl.meaning.type_lookup import TypeLookup
from rtgen.compiler.frontends.idl.names.scopes import Entity, Kind
from rtgen.compiler.frontends.idl.rules import constants as rules
from rtgen.compiler.frontends.idl.rules import names as name_rules
from rtgen.compiler.frontends.idl.rules import syntax
from rtgen.compiler.frontends.idl.rules import types as type_rules
from rtgen.compiler.frontends.idl.syntax import literals, tree
from rtgen.compiler.frontends.idl.text.unit import Unit
from rtgen.compiler.kit.limits import MAX_NESTING
from rtgen.compiler.model import (
    ConstantValue,
    EnumeratorName,
    FixedType,
    NamedType,
    Primitive,
    PrimitiveType,
    StringType,
    Type,
)
from rtgen.facts.primitives import INTEGER_RANGES


class _NoValueError(Exception):
    """Raised for an expression without a value; a diagnostic has been reported."""


class Constants:
    """Evaluates expressions; diagnostics go to `report`."""

    def __init__(self, types: TypeLookup, report: Callable[[Diagnostic], None]) -> None:
        self._types = types
        self._report = report
        self._values: dict[Entity, ConstantValue | None] = {}
        self._unit: Unit
        self._bits = self._complement = 32
        self._signed = True

    def value_of(self, entity: Entity) -> ConstantValue | None:
        """Return the value of a constant; None if it has an error."""
        if entity not in self._values:
            self._values[entity] = None
            node = entity.node
            assert isinstance(node, tree.Const)
            type_ = self._types.of_node(node.type, entity.unit)
            if type_ is not None:
                self._values[entity] = self.evaluate(node.value, type_, entity.unit)
        return self._values[entity]

    def evaluate(
        self, node: tree.Expression, type_: Type, unit: Unit, what: str = "constant"
    ) -> ConstantValue | None:
        """Evaluate an expression for a type; None, with a diagnostic, if it has no value."""
        plain = self._types.unaliased(type_)
        if plain is None:
            return None
        operand_class = operand_class_of(plain, self._types.is_enum)
        saved = (
            *(getattr(self, "_unit", unit), self._bits, self._signed),
            self._complement,
        )
        self._unit = unit
        wide = isinstance(plain, PrimitiveType) and plain.kind in WIDE
        self._bits = self._complement = 64 if wide else 32
        self._signed = (
            not isinstance(plain, PrimitiveType)
            or INTEGER_RANGES.get(plain.kind, (-1, 0))[0] < 0
        )
        try:
            if operand_class is None:
                self._fail(
                    type_rules.BAD_CONST_TYPE,
                    node,
                    f"no {what} can be of type {type_}",
                    "constants are numbers, characters, strings, booleans and enumerators",
                )
            assert operand_class is not None
            value = self._evaluate(node, operand_class, 0)
            width = NARROW.get(plain.kind) if isinstance(plain, PrimitiveType) else None
            if width is not None and isinstance(value, int) and value >= 1 << width:
                self._complement = width
                value = self._evaluate(node, operand_class, 0)
            return self._fit(value, plain, node)
        except _NoValueError:
            return None
        finally:
            self._unit, self._bits, self._signed, self._complement = saved

    def positive(self, node: tree.Expression, unit: Unit) -> int | None:
        """Evaluate a bound or dimension; None, with a diagnostic, unless it is positive."""
        value = self.evaluate(node, PrimitiveType(Primitive.LONG_LONG), unit, "bound")
        if value is None:
            return None
        assert isinstance(value, int)
        if not 1 <= value < 2**32:
            self._unit = unit
            span = unit.span(node.start, node.end)
            self._report(
                type_rules.BAD_BOUND.at(
                    span, f"{value} is not from 1 to 4294967295", hint=BOUND_HINT
                )
            )
            return None
        return value

    def _fail(
        self,
        rule: Rule,
        node: tree.Expression,
        message: str,
        hint: str | None = None,
        declared: Entity | None = None,
    ) -> None:
        self._report_at(rule, node, message, hint, declared)
        raise _NoValueError

    def _report_at(
        self,
        rule: Rule,
        node: tree.Expression,
        message: str,
        hint: str | None = None,
        declared: Entity | None = None,
    ) -> None:
        if declared is None and isinstance(node, tree.ScopedName):
            entity = self._types.tables.references.get(node)
            declared = entity if isinstance(entity, Entity) else None
        related = [Related(declared.span, "declared here")] if declared else []
        span = self._unit.span(node.start, node.end)
        self._report(rule.at(span, message, related=related, hint=hint))

    def _evaluate(
        self, node: tree.Expression, target: OperandClass, depth: int
    ) -> ConstantValue:
        if depth > MAX_NESTING:
            self._fail(syntax.TOO_DEEP, node, "this expression is nested too deeply")
        match node:
            case tree.Group(inner):
                return self._evaluate(inner, target, depth + 1)
            case tree.Number():
                return self._number(node, target)
            case tree.Text():
                return self._text(node, target)
            case tree.Boolean():
                if target is not OperandClass.BOOLEAN:
                    self._mixed(node, target, OperandClass.BOOLEAN)
                return node.value
            case tree.ScopedName():
                return self._named(node, target)
            case tree.Unary(operator, operand):
                self._has_operators(node, target)
                value = self._evaluate(operand, target, depth + 1)
                return self._checked(self._unary(operator, value, node, target), node)
            case tree.Chain(first, rest):
                self._has_operators(node, target)
                value = self._evaluate(first, target, depth + 1)
                for operator, operand in rest:
                    right = self._evaluate(operand, target, depth + 1)
                    value = self._checked(
                        self._binary(operator, value, right, operand), node
                    )
                return value

    def _has_operators(self, node: tree.Expression, target: OperandClass) -> None:
        if target not in (OperandClass.INTEGER, OperandClass.FLOAT, OperandClass.FIXED):
            hint = (
                "adjacent strings are joined"
                if target in (OperandClass.TEXT, OperandClass.WIDE_TEXT)
                else None
            )
            self._fail(rules.WRONG_KIND, node, f"{target} has no operators", hint)

    def _mixed(
        self, node: tree.Expression, target: OperandClass, operand_class: OperandClass
    ) -> None:
        self._fail(
            rules.WRONG_KIND,
            node,
            f"{target} is expected here, not {operand_class}",
            CONVERSIONS.get((target, operand_class)) or EXAMPLES[target],
        )

    def _number(self, node: tree.Number, target: OperandClass) -> ConstantValue:
        try:
            value = literals.number(node.text)
        except literals.LiteralError as error:
            self._fail(syntax.BAD_LITERAL, node, str(error), error.hint)
            raise _NoValueError from error
        match value:
            case int():
                return self._from_integer(value, node, target)
            case float() if target is OperandClass.FLOAT:
                return value
            case Decimal() if target is OperandClass.FIXED:
                return value
        self._mixed(
            node,
            target,
            OperandClass.FLOAT if isinstance(value, float) else OperandClass.FIXED,
        )
        return value

    def _from_integer(
        self, value: int, node: tree.Expression, target: OperandClass
    ) -> ConstantValue:
        if target in (OperandClass.FLOAT, OperandClass.FIXED):
            example = f"{value}.0" if target is OperandClass.FLOAT else f"{value}d"
            message, hint = f"{target} is expected here", f"write {example}"
            self._report_at(rules.INTEGER_AS_FLOAT, node, message, hint)
            return float(value) if target is OperandClass.FLOAT else Decimal(value)
        if target is not OperandClass.INTEGER:
            self._mixed(node, target, OperandClass.INTEGER)
        low, high = self._bounds()
        if not low <= value <= high:
            self._overflow(node, value)
        return value

    def _bounds(self) -> tuple[int, int]:
        return -(2 ** (self._bits - 1)), 2**self._bits - 1

    def _overflow(self, node: tree.Expression, value: int) -> None:
        low, high = self._bounds()
        self._fail(
            rules.OUT_OF_RANGE,
            node,
            f"{brief(value)} is not from {low} to {high}",
            wider(value),
        )

    def _text(self, node: tree.Text, target: OperandClass) -> ConstantValue:
        try:
            text = literals.text(node.parts, node.character)
        except literals.LiteralError as error:
            self._fail(syntax.BAD_LITERAL, node, str(error), error.hint)
            raise _NoValueError from error
        for escape in text.unknown_escapes:
            message = f"\\{escape} is not an escape; {escape} is taken"
            hint = f"write {escape}, or \\\\ for a backslash"
            self._report_at(syntax.UNKNOWN_ESCAPE, node, message, hint)
        if text.broken:
            self._report_at(
                syntax.BROKEN_STRING,
                node,
                "this string goes over several lines",
                'write \\n for a line break, and "..." "..." for a long string',
            )
        sorts = (
            (OperandClass.CHARACTER, OperandClass.WIDE_CHARACTER)
            if node.character
            else (OperandClass.TEXT, OperandClass.WIDE_TEXT)
        )
        if target is not sorts[text.wide]:
            self._mixed(node, target, sorts[text.wide])
        return text.value

    def _named(self, node: tree.ScopedName, target: OperandClass) -> ConstantValue:
        entity = self._types.tables.references.get(node)
        if entity is None:
            raise _NoValueError
        if isinstance(entity, Entity) and entity.kind is Kind.ENUMERATOR:
            if target is not OperandClass.ENUM:
                self._mixed(node, target, OperandClass.ENUM)
            return EnumeratorName(entity.path)
        if not isinstance(entity, Entity) or entity.kind is not Kind.CONST:
            self._fail(
                name_rules.NOT_A_VALUE,
                node,
                f"{node} is not a constant",
                "a value is a literal, a constant or an enumerator",
                entity if isinstance(entity, Entity) else None,
            )
            raise _NoValueError
        value = self.value_of(entity)
        assert isinstance(entity.node, tree.Const)
        type_ = self._types.unaliased(
            self._types.of_node(entity.node.type, entity.unit)
        )
        if value is None or type_ is None:
            raise _NoValueError
        operand_class = operand_class_of(type_, self._types.is_enum)
        if operand_class is OperandClass.INTEGER and isinstance(value, int):
            return self._from_integer(value, node, target)
        if operand_class is not target:
            self._mixed(node, target, operand_class or OperandClass.INTEGER)
        return value

    def _unary(
        self,
        operator: str,
        value: ConstantValue,
        node: tree.Expression,
        target: OperandClass,
    ) -> ConstantValue:
        if isinstance(value, int) and not isinstance(value, bool):
            match operator:
                case "-":
                    return -value
                case "~" if self._signed or value < 0:
                    return -(value + 1)
                case "~":
                    return (1 << self._complement) - 1 - value
            return value
        assert isinstance(value, float | Decimal)
        if operator == "~":
            hint = "'~' is the complement of an integer"
            self._fail(rules.WRONG_KIND, node, f"{target} has no '~'", hint)
        return -value if operator == "-" else value

    def _binary(
        self,
        operator: str,
        left: ConstantValue,
        right: ConstantValue,
        node: tree.Expression,
    ) -> ConstantValue:
        if operator in ("/", "%") and not right:
            hint = "the right operand must not be zero"
            self._fail(rules.DIVISION_BY_ZERO, node, "division by zero", hint)
        if isinstance(left, int) and isinstance(right, int):
            return self._integers(operator, left, right, node)
        if isinstance(left, float) and isinstance(right, float):
            match operator:
                case "+":
                    return left + right
                case "-":
                    return left - right
                case "*":
                    return left * right
                case "/":
                    return left / right
        if isinstance(left, Decimal) and isinstance(right, Decimal):
            match operator:
                case "+":
                    return EXACT.add(left, right)
                case "-":
                    return EXACT.subtract(left, right)
                case "*":
                    return EXACT.multiply(left, right)
                case "/":
                    return DIGITS_31.divide(left, right)
        hint = "floating- and fixed-point numbers have + - * /"
        self._fail(rules.WRONG_KIND, node, f"'{operator}' requires integers", hint)
        raise _NoValueError

    def _integers(
        self, operator: str, left: int, right: int, node: tree.Expression
    ) -> int:
        match operator:
            case "|":
                return left | right
            case "^":
                return left ^ right
            case "&":
                return left & right
            case "+":
                return left + right
            case "-":
                return left - right
            case "*":
                return left * right
            case "<<" | ">>":
                if not 0 <= right < self._bits:
                    message = (
                        f"a shift by {brief(right)} is not from 0 to {self._bits - 1}"
                    )
                    hint = "64-bit types such as long long can be shifted by 0 to 63"
                    hint = hint if self._bits < 64 else "shift by fewer bits"
                    self._fail(rules.BAD_SHIFT, node, message, hint)
                return left << right if operator == "<<" else left >> right
        quotient = abs(left) // abs(right)
        if (left < 0) != (right < 0):
            quotient = -quotient
        if operator == "/":
            return quotient
        if left < 0 or right < 0:
            message = "the remainder has the sign of the left operand"
            hint = "write the value itself if other compilers read this too"
            self._report_at(rules.NEGATIVE_REMAINDER, node, message, hint)
        return left - quotient * right

    def _checked(self, value: ConstantValue, node: tree.Expression) -> ConstantValue:
        """Check an intermediate result against the range of omniidl's arithmetic."""
        if isinstance(value, int) and not isinstance(value, bool):
            low, high = self._bounds()
            if not low <= value <= high:
                self._overflow(node, value)
        elif isinstance(value, float):
            if not isfinite(value) and isinstance(node, tree.Chain):
                message = "the value is beyond the range of a double"
                self._fail(rules.OUT_OF_RANGE, node, message)
        elif isinstance(value, Decimal):
            if value and value.adjusted() >= 31:
                message = "the value has more than 31 digits before its point"
                self._fail(rules.OUT_OF_RANGE, node, message)
            return DIGITS_31.plus(value)
        return value

    def _fit(
        self, value: ConstantValue, type_: Type, node: tree.Expression
    ) -> ConstantValue:
        """Convert a value to the target type."""
        match type_:
            case PrimitiveType(kind) if kind in INTEGER_RANGES:
                low, high = INTEGER_RANGES[kind]
                assert isinstance(value, int)
                if not low <= value <= high:
                    message = f"{value} is out of the range of {kind}: {low} to {high}"
                    self._fail(rules.OUT_OF_RANGE, node, message, wider(value))
            case PrimitiveType(kind) if kind in FLOATS:
                assert isinstance(value, float)
                return self._fit_float(value, kind, node)
            case StringType(bound=bound) if bound is not None:
                assert isinstance(value, str)
                if len(value) > bound:
                    message = f"{len(value)} characters do not fit into {type_}"
                    hint = "shorten it, or raise the bound"
                    self._fail(rules.TEXT_TOO_LONG, node, message, hint)
            case FixedType(digits, scale):
                assert isinstance(value, Decimal)
                if digits:
                    value = self._fit_fixed(value, digits, scale, node)
                return without_zeros(value)
            case NamedType(name):
                assert isinstance(value, EnumeratorName)
                owner = self._types.enum_of(value.name)
                if owner != name:
                    message = f"{'::'.join(value.name)} is not an enumerator of {'::'.join(name)}"
                    hint = f"write an enumerator of {'::'.join(name)}"
                    self._fail(rules.WRONG_ENUM, node, message, hint)
        return value

    def _fit_float(self, value: float, kind: Primitive, node: tree.Expression) -> float:
        largest = LARGEST_FLOAT if kind is Primitive.FLOAT else LARGEST_DOUBLE
        if abs(value) > largest:
            hint = (
                "write double for a larger range"
                if kind is Primitive.FLOAT
                else "the largest double is about 1.8e308"
            )
            if is_literal(node):
                message = f"the value is beyond the range of a {kind}: it is infinite"
                self._report_at(rules.INFINITE, node, message, hint)
            else:
                message = f"the value is beyond the range of a {kind}"
                self._fail(rules.OUT_OF_RANGE, node, message, hint)
            value = copysign(inf, value)
        if kind is Primitive.LONG_DOUBLE:
            message = "the constant is kept as a double"
            hint = "write double if that is precise enough"
            self._report_at(type_rules.LONG_DOUBLE, node, message, hint)
        if kind is Primitive.FLOAT:
            rounded: float = struct.unpack("<f", struct.pack("<f", value))[0]
            return rounded
        return value

    def _fit_fixed(
        self, value: Decimal, digits: int, scale: int, node: tree.Expression
    ) -> Decimal:
        cut = value.quantize(
            Decimal(1).scaleb(-scale), rounding=ROUND_DOWN, context=EXACT
        )
        if abs(cut) >= Decimal(10) ** (digits - scale):
            message = f"{value} does not fit into fixed<{digits},{scale}>"
            hint = f"it allows {max(digits - scale, 0)} digits before the point"
            self._fail(rules.OUT_OF_RANGE, node, message, hint)
        if cut != value:
            message = f"{value} is cut to {scale} digits after the point"
            self._report_at(rules.PRECISION, node, message, f"write {cut}d")
            return cut
        return value
