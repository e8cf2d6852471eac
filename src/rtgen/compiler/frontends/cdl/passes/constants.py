"""Pass over constants: reads types, adds values; validates initialisers against their types."""

from __future__ import annotations

import math
from collections.abc import Mapping

from rtgen.compiler.diagnostics import Rule
from rtgen.compiler.frontends.cdl.names.c_types import is_const
from rtgen.compiler.frontends.cdl.names.entities import Place
from rtgen.compiler.frontends.cdl.names.operands import (
    Operand,
    OperandClass,
    operand_class_of,
)
from rtgen.compiler.frontends.cdl.names.scopes import Kind
from rtgen.compiler.frontends.cdl.names.table import Table
from rtgen.compiler.frontends.cdl.passes.arithmetic import limits, width
from rtgen.compiler.frontends.cdl.passes.expressions import Expressions
from rtgen.compiler.frontends.cdl.passes.types import Types
from rtgen.compiler.frontends.cdl.passes.untagged import name_of_untagged
from rtgen.compiler.frontends.cdl.rules import constants as rules
from rtgen.compiler.frontends.cdl.syntax import statements, tree
from rtgen.compiler.model.c_types import (
    AggregateExpression,
    CArrayType,
    CExpression,
    CPointerType,
    CScalarType,
    CStructType,
    CType,
    Expression,
    Literal,
    Reference,
    resolve,
)
from rtgen.compiler.model.tecs import TecsConst, TecsStruct
from rtgen.facts.tdr import Scalar

_CHARACTERS = (Scalar.CHAR, Scalar.SCHAR, Scalar.UCHAR)


class Constants:
    """Declares constants and validates initialisers."""

    def __init__(self, table: Table, types: Types) -> None:
        self._table = table
        self._types = types

    def declare(
        self, item: statements.Item, node: tree.Declaration, place: Place
    ) -> None:
        """Declare the constants of a statement."""
        untagged = name_of_untagged(each.declarator for each in node.declarators)
        base = self._types.of(node.type, place, untagged)
        for declarator in node.declarators:
            name = declarator.declarator.name
            assert name is not None
            entity = self._table.declare(Kind.CONSTANT, name, item, place)
            type_ = self._types.declared(base, declarator.declarator, place)
            if entity is None or type_ is None:
                continue
            if not self._types.knows_struct(type_, place, name):
                continue
            if not self._is_constant(type_, name, place, declarator.value is not None):
                continue
            assert declarator.value is not None
            look = _Initial(self._types.expressions, place, {})
            value = look.of(declarator.value, type_)
            if value is None:
                continue
            entity.value = look.found
            entity.declaration = TecsConst(
                name=entity.name,
                file=place.unit.source.name,
                span=entity.place,
                doc=place.doc(item),
                type=type_,
                value=value.value if isinstance(value, Literal) else None,
            )
            self._table.declared(entity)

    def _is_constant(
        self, type_: CType, name: tree.Name, place: Place, has_value: bool
    ) -> bool:
        span = place.span(name)
        found = resolve(type_)
        if not is_const(type_):
            pointer = isinstance(found, CPointerType)
            hint = (
                f"write *const {name.text}"
                if pointer
                else "write const before the type"
            )
            message = f"'{name.text}' is not const"
            self._table.report(rules.NOT_CONST.at(span, message, hint=hint))
        elif operand_class_of(type_) not in (
            OperandClass.INTEGER,
            OperandClass.FLOAT,
            OperandClass.BOOL,
            OperandClass.POINTER,
        ) or (isinstance(found, CArrayType)):
            message = f"a constant cannot be of type {type_}"
            self._table.report(rules.CONSTANT_TYPE.at(span, message))
        elif not has_value:
            message = f"the constant '{name.text}' has no value"
            self._table.report(rules.NO_INITIALISER.at(span, message))
        else:
            return True
        return False

    def initial(
        self,
        value: tree.Initialiser,
        type_: CType,
        place: Place,
        names: Mapping[str, CType] | None = None,
    ) -> Expression | None:
        """Return the model of an initialiser of the type; None, after a diagnostic, if invalid."""
        return _Initial(self._types.expressions, place, names or {}).of(value, type_)


class _Initial:
    def __init__(
        self, expressions: Expressions, place: Place, names: Mapping[str, CType]
    ) -> None:
        self._expressions = expressions
        self._table = expressions.table
        self._place = place
        self._names = names
        self.found: Operand | None = None
        """The value before conversion to the type; None for lists and C_EXP."""

    def _report(
        self, rule: Rule, node: tree.Initialiser, message: str, hint: str | None = None
    ) -> None:
        span = self._place.span(node)
        self._table.report(rule.at(span, message, hint=hint))

    def of(self, value: tree.Initialiser, type_: CType) -> Expression | None:
        """Return the model of a value of the type; None, after a diagnostic, if invalid."""
        if isinstance(value, tree.CExp):
            if isinstance(resolve(type_), CArrayType):
                self._report(
                    rules.SHAPE, value, "an array requires its values in braces"
                )
                return None
            return CExpression(value.text.text)
        if isinstance(value, tree.Aggregate):
            return self._aggregate(value, type_)
        found = self._expressions.operand(value, self._place, self._names)
        if found is None:
            return None
        self.found = found
        return self._single(value, found, type_)

    def _aggregate(self, value: tree.Aggregate, type_: CType) -> Expression | None:
        target = resolve(type_)
        if isinstance(target, CArrayType | CPointerType):
            element = (
                target.element if isinstance(target, CArrayType) else target.target
            )
            size = target.size if isinstance(target, CArrayType) else None
            if size is not None and len(value.items) > size:
                message = f"{len(value.items)} values for an array of {size}"
                self._report(rules.SHAPE, value, message)
                return None
            wanted = [element] * len(value.items)
        elif isinstance(target, CStructType):
            entity = self._table.tag(target.tag)
            if entity is None or not isinstance(entity.declaration, TecsStruct):
                return None
            members = entity.declaration.members
            if len(value.items) > len(members):
                message = (
                    f"{len(value.items)} values for {len(members)} members of {target}"
                )
                self._report(rules.SURPLUS, value, message)
            wanted = [member.type for member in members]
        else:
            self._report(
                rules.SHAPE, value, f"{type_} requires a single value, without braces"
            )
            return None
        models = [
            self.of(item, element)
            for item, element in zip(value.items, wanted, strict=False)
        ]
        good = tuple(model for model in models if model is not None)
        return AggregateExpression(good) if len(good) == len(models) else None

    def _single(
        self, node: tree.Expression, found: Operand, type_: CType
    ) -> Expression | None:
        wanted = operand_class_of(type_)
        target = resolve(type_)
        if isinstance(target, CArrayType):
            self._report(rules.SHAPE, node, "an array requires its values in braces")
            return None
        if wanted is OperandClass.STRUCT:
            if found.type is not None and resolve(found.type) == target:
                return found.model
            self._report(rules.SHAPE, node, f"{target} requires its values in braces")
            return None
        if isinstance(target, CPointerType):
            return self._pointer(node, found, target)
        if (
            wanted is OperandClass.UNKNOWN
            or found.operand_class is OperandClass.UNKNOWN
        ):
            return found.model
        if wanted is OperandClass.BOOL:
            # tecsgen accepts any value as a boolean; a string is never a null pointer.
            truth = found.operand_class is OperandClass.STRING or bool(found.value)
            return found.model if found.value is None else Literal(truth)
        if found.operand_class in (
            OperandClass.STRING,
            OperandClass.POINTER,
            OperandClass.STRUCT,
        ):
            message = f"{found.operand_class.with_article} cannot be {type_}"
            self._report(rules.OPERATOR_KIND, node, message)
            return None
        if wanted is OperandClass.INTEGER:
            return self._integer(node, found, type_)
        if found.operand_class is OperandClass.BOOL:
            message = f"a truth value cannot be {type_}"
            self._report(rules.OPERATOR_KIND, node, message, "cast it")
            return None
        if isinstance(found.value, int | float):
            return Literal(_float(found.value))
        return found.model

    def _integer(
        self, node: tree.Expression, found: Operand, type_: CType
    ) -> Expression | None:
        if found.operand_class is OperandClass.FLOAT:
            hint = f"write ({_plain(type_)})"
            message = f"a floating-point number needs a cast to become {type_}"
            self._report(rules.NEEDS_CAST, node, message, hint)
            return None
        if found.operand_class is OperandClass.BOOL and found.value is not None:
            message = f"a truth value cannot be {type_}"
            self._report(rules.OPERATOR_KIND, node, message, f"write ({_plain(type_)})")
            return None
        if found.value is None:
            return found.model
        assert not isinstance(found.value, str)
        number = int(found.value)
        low, high = limits(type_)
        if (low is not None and number < low) or (high is not None and number > high):
            why = f": {low} to {high}" if high is not None else ", it is below zero"
            self._report(rules.RANGE, node, f"{number} does not fit {type_}{why}")
            return None
        return Literal(number)

    def _pointer(
        self, node: tree.Expression, found: Operand, target: CPointerType
    ) -> Expression | None:
        if found.operand_class is OperandClass.STRING and not is_character(
            target.target
        ):
            message = f"a string cannot be {target}"
            self._report(rules.POINTER_VALUE, node, message)
            return None
        of_attribute = (
            isinstance(found.model, Reference) and found.model.name in self._names
        )
        if (
            found.operand_class is OperandClass.POINTER
            and not of_attribute
            and not _is_same_pointer(target, found.type)
        ):
            message = f"{found.type} is another pointer than {target}"
            self._report(
                rules.POINTER_VALUE, node, message, f"write ({_plain(target)})"
            )
            return None
        if found.operand_class in (
            OperandClass.UNKNOWN,
            OperandClass.STRING,
            OperandClass.POINTER,
        ):
            return found.model
        if found.operand_class is OperandClass.INTEGER and found.value == 0:
            return found.model
        message = f"{found.operand_class.with_article} cannot be {target}"
        self._report(rules.POINTER_VALUE, node, message, f"write ({_plain(target)})")
        return None


def _plain(type_: CType) -> str:
    """Return the type as written in a cast, without top-level qualifiers."""
    return str(type_).removeprefix("const ").removesuffix(" const")


def is_character(type_: CType) -> bool:
    """Return whether a pointer to the type accepts a string; tecsgen rejects typedefs."""
    return isinstance(type_, CScalarType) and type_.kind in _CHARACTERS


def _is_same_pointer(one: CType, other: CType | None) -> bool:
    """Return whether tecsgen considers two pointer types equal.

    It compares their targets, level by level, by kind and width.
    """
    while isinstance(one, CPointerType) and isinstance(other, CPointerType):
        one, other = one.target, other.target
        if type(one) is not type(other):
            return False
        if (
            isinstance(one, CScalarType)
            and isinstance(other, CScalarType)
            and width(one.kind) != width(other.kind)
        ):
            return False
    return True


def _float(value: float) -> float:
    try:
        return float(value)
    except OverflowError:
        return math.inf
