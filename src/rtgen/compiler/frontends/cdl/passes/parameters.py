"""Pass over the parameters of functions: reads types and names, makes `TecsParameter`s."""

from __future__ import annotations

import msgspec

from rtgen.compiler.diagnostics import Related, Rule
from rtgen.compiler.frontends.cdl.names.c_types import is_const, is_void, pointer_depth
from rtgen.compiler.frontends.cdl.names.entities import Place
from rtgen.compiler.frontends.cdl.names.operands import Operand, OperandClass
from rtgen.compiler.frontends.cdl.names.scopes import Entity, Kind
from rtgen.compiler.frontends.cdl.names.table import Table
from rtgen.compiler.frontends.cdl.passes.arithmetic import whole_number
from rtgen.compiler.frontends.cdl.passes.specifiers import belongs
from rtgen.compiler.frontends.cdl.passes.types import Types
from rtgen.compiler.frontends.cdl.passes.untagged import name_of_untagged
from rtgen.compiler.frontends.cdl.rules import signatures as rules
from rtgen.compiler.frontends.cdl.rules import syntax
from rtgen.compiler.frontends.cdl.rules import types as type_rules
from rtgen.compiler.frontends.cdl.syntax import tree
from rtgen.compiler.frontends.kit.nodes import Spanned
from rtgen.compiler.model.c_types import (
    CArrayType,
    CEnumType,
    CFunctionType,
    CPointerType,
    CStructType,
    CType,
    Expression,
    Reference,
    resolve,
)
from rtgen.compiler.model.tecs import Sizes, TecsDirection, TecsParameter
from rtgen.compiler.model.types import ScopedName
from rtgen.facts.tdr import Scalar

_DIRECTIONS = {direction.value: direction for direction in TecsDirection}
_LENGTHS = ("size_is", "count_is", "string")
_ALLOWED = frozenset((*_DIRECTIONS, *_LENGTHS, "nullable"))
_NO_SIZES = Sizes()
_INWARD = (TecsDirection.IN, TecsDirection.INOUT)
_OUTWARD = (TecsDirection.OUT, TecsDirection.INOUT)


class SignatureAnalysis(msgspec.Struct, eq=False):
    """The signature under analysis, and how its errors are reported."""

    _table: Table
    _types: Types
    _place: Place
    deviate: bool = False

    def _report(
        self, rule: Rule, node: Spanned, message: str, hint: str | None = None
    ) -> None:
        self._table.report(rule.at(self._place.span(node), message, hint=hint))


class _Parameter(msgspec.Struct, eq=False):
    """A parameter under analysis."""

    written: tree.Parameter
    name: tree.Name
    type: CType
    given: dict[str, tree.Specifier] = {}
    direction: TecsDirection | None = None
    allocator: ScopedName | None = None
    good: bool = True


class ParameterAnalysis(SignatureAnalysis):
    """Analyses the parameters of one function."""

    def of(self, listed: tree.Parameters) -> tuple[TecsParameter, ...] | None:
        """Return the model of a function's parameters; None, after diagnostics, if one is
        invalid.
        """
        if len(listed.items) == 1 and self._is_nothing(listed.items[0]):
            return ()
        found: dict[str, _Parameter] = {}
        good = True
        for item in listed.items:
            parameter = self._parameter(item)
            if parameter is None:
                good = False
            elif parameter.name.text in found:
                first = found[parameter.name.text].name
                self._table.report(
                    rules.PARAMETER_TWICE.at(
                        self._place.span(parameter.name),
                        f"the parameter '{parameter.name.text}' is declared already",
                        related=[
                            Related(self._place.span(first), "first declared here")
                        ],
                    )
                )
                good = False
            else:
                found[parameter.name.text] = parameter
        made = []
        names = {name: parameter.type for name, parameter in found.items()}
        directions = {name: p.direction for name, p in found.items()}
        for parameter in found.values():
            sizes = self._sizes(parameter, names, directions if good else {})
            if sizes is None or not parameter.good or parameter.direction is None:
                good = False
                continue
            written = parameter.written
            made.append(
                TecsParameter(
                    name=parameter.name.text,
                    type=parameter.type,
                    direction=parameter.direction,
                    sizes=sizes,
                    allocator=parameter.allocator,
                    span=self._place.span(parameter.name),
                    doc=self._place.doc(written),
                )
            )
        return tuple(made) if good else None

    def _is_nothing(self, item: tree.Parameter) -> bool:
        """Return whether it is the `void` of a function without parameters."""
        if item.declarator is not None or item.specifiers is not None:
            return False
        written = item.type.type
        return isinstance(written, tree.BasicType) and written.kind is Scalar.VOID

    def _parameter(self, item: tree.Parameter) -> _Parameter | None:
        name = item.declarator.name if item.declarator is not None else None
        if len(item.type.qualifiers) > 1:
            message = "a parameter has one qualifier at most"
            self._report(syntax.QUALIFIER, item.type.qualifiers[1], message)
            return None
        untagged = name_of_untagged((item.declarator,))
        base = self._types.of(item.type, self._place, untagged)
        type_ = self._types.declared(base, item.declarator, self._place)
        if name is None:
            if type_ is not None and is_void(type_) and item.declarator is None:
                self._report_void(item)
                return None
            message = "this parameter has no name"
            self._report(rules.NO_NAME, item, message)
            return None
        if item.specifiers is None:
            message = f"the parameter '{name.text}' has no specifiers"
            hint = "write [in], [out] or [inout] before it"
            self._report(rules.NO_BRACKET, item, message, hint)
            return None
        if type_ is None:
            return None
        parameter = _Parameter(item, name, type_)
        self._specifiers(parameter, item.specifiers)
        if is_void(type_):
            message = f"the parameter '{name.text}' cannot be of type void"
            self._report(type_rules.VOID_VALUE, name, message)
            return None
        inner = resolve(type_)
        if isinstance(inner, CFunctionType):
            message = f"the parameter '{name.text}' cannot be a function"
            self._report(rules.FUNCTION_PARAMETER, name, message, "use a pointer to it")
            return None
        if isinstance(inner, CStructType | CArrayType | CPointerType):
            parameter.good &= self._types.is_value(type_, self._place, name)
        if isinstance(inner, CEnumType):
            message = f"'{name.text}' is an enum, which tecsgen cannot make code for"
            hint = "use an integer and constants"
            self._report(type_rules.ENUM_TYPE, name, message, hint)
        if parameter.good:
            self._pointers(parameter)
        return parameter

    def _report_void(self, item: tree.Parameter) -> None:
        span = self._place.span(item)
        message = (
            "'void' must be alone in the parentheses of a function without parameters"
        )
        self._table.report(type_rules.VOID_VALUE.at(span, message))

    def _specifiers(self, parameter: _Parameter, bracket: tree.Specifiers) -> None:
        for specifier in bracket.items:
            word = specifier.word
            if word not in _ALLOWED:
                message = f"'{word}' cannot precede a parameter"
                hint = belongs(specifier.word)
                self._report(syntax.MISPLACED_SPECIFIER, specifier, message, hint)
                parameter.good = False
            elif word in _DIRECTIONS:
                self._direction(parameter, specifier)
            elif word in _LENGTHS and word in parameter.given:
                message = f"'{word}' is given already"
                self._report(rules.SPECIFIER_TWICE, specifier, message)
                parameter.good = False
            else:
                parameter.given[word] = specifier
        if bracket.broken:
            parameter.good = False
        if parameter.direction is None and parameter.good:
            message = f"'{parameter.name.text}' has no direction"
            hint = "add in, out or inout"
            self._report(rules.NO_DIRECTION, bracket, message, hint)
            parameter.good = False

    def _direction(self, parameter: _Parameter, specifier: tree.Specifier) -> None:
        direction = _DIRECTIONS[specifier.word]
        if parameter.direction is direction:
            message = f"'{direction}' is given already"
            self._report(rules.DIRECTION_TWICE, specifier, message)
        elif parameter.direction is not None:
            message = f"'{parameter.name.text}' is {parameter.direction} already"
            hint = None
            if {direction, parameter.direction} == {
                TecsDirection.IN,
                TecsDirection.OUT,
            }:
                hint = "write inout for both"
            self._report(rules.DIRECTION_CONFLICT, specifier, message, hint)
            parameter.good = False
        else:
            parameter.direction = direction
        if specifier.arguments:
            (name,) = specifier.arguments
            assert isinstance(name, tree.ScopedName)
            found = self._place.scope.find(name)
            if isinstance(found, Entity) and found.kind is Kind.SIGNATURE:
                parameter.allocator = found.name
            else:
                message = f"'{name}' is not a signature"
                hint = "name the signature of the allocator; it is declared before"
                self._report(rules.ALLOCATOR, name, message, hint)
                parameter.good = False

    def _pointers(self, parameter: _Parameter) -> None:
        """Check pointer levels and `const` according to the specifiers."""
        is_pointer = isinstance(resolve(parameter.type), CPointerType)
        plain = not is_pointer and not parameter.given
        if plain and parameter.direction is TecsDirection.IN:
            return
        if not is_pointer:
            self._report_pointer_specifiers(parameter)
        if not parameter.good or not self._levels(parameter):
            return
        target = _target(parameter.type)
        if is_pointer:
            self._constness(parameter, target)
        self._report_void_sizes(parameter, target)
        self._combinations(parameter)

    def _report_pointer_specifiers(self, parameter: _Parameter) -> None:
        """Report pointer specifiers on a parameter that is not a pointer."""
        for word in (*_LENGTHS, "nullable"):
            if word in parameter.given:
                name = parameter.name.text
                message = f"'{word}' applies to pointers, and '{name}' is not one"
                self._report(rules.SIZE_OF_SCALAR, parameter.given[word], message)
                parameter.good = False

    def _levels(self, parameter: _Parameter) -> bool:
        """Check the number of pointer levels; False if there are too few."""
        name, depth = parameter.name, pointer_depth(parameter.type)
        needed = _needed_levels(parameter)
        most = max(needed, 1)
        if "size_is" in parameter.given and _leads_to_struct(parameter.type):
            most += 1
        if depth < needed:
            more = "a pointer" if needed == 1 else f"{needed} levels of pointers"
            message = f"'{name.text}' must be {more}"
            hint = f"write '{'*' * needed}{name.text}'"
            self._report(rules.TOO_FEW_POINTERS, name, message, hint)
            parameter.good = False
            return False
        if depth > most and not self.deviate:
            message = f"'{name.text}' has {depth} levels of pointers, {most} would do"
            self._report(rules.TOO_MANY_POINTERS, name, message)
        return True

    def _report_void_sizes(self, parameter: _Parameter, target: CType) -> None:
        """Report sizes of a pointer to void."""
        given, depth = parameter.given, pointer_depth(parameter.type)
        received = parameter.direction is TecsDirection.RECEIVE and depth > 1
        size = "size_is" in given or "count_is" in given
        if ("string" in given or (size and depth - received == 1)) and is_void(target):
            words = " and ".join(word for word in _LENGTHS if word in given)
            message = f"{words} cannot apply to a pointer to void"
            self._report(rules.SIZE_OF_VOID, parameter.name, message)
            parameter.good = False

    def _combinations(self, parameter: _Parameter) -> None:
        """Report incompatible specifiers."""
        name, given = parameter.name, parameter.given
        if "nullable" in given and "size_is" in given:
            message = "an array cannot be nullable"
            hint = "a NULL array has size 0"
            self._report(rules.NULLABLE_SIZE, given["nullable"], message, hint)
            parameter.good = False
        unsized = "string" in given and not given["string"].arguments
        if unsized and parameter.direction in (TecsDirection.OUT, TecsDirection.INOUT):
            message = f"the {parameter.direction} string '{name.text}' has no length"
            hint = "write string( n )"
            self._report(rules.STRING_LENGTH, given["string"], message, hint)

    def _constness(self, parameter: _Parameter, target: CType) -> None:
        name, direction = parameter.name, parameter.direction
        if direction is TecsDirection.IN:
            if not is_const(target):
                message = f"'{name.text}' is in, so its target must be const"
                hint = f"write const {target} *{name.text}"
                self._report(rules.IN_NOT_CONST, name, message, hint)
                parameter.good = False
        elif is_const(target) and not self.deviate:
            message = f"'{name.text}' is {direction}, so its target cannot be const"
            self._report(rules.OUT_CONST, name, message, "leave out const")
            parameter.good = False

    def _sizes(
        self,
        parameter: _Parameter,
        names: dict[str, CType],
        directions: dict[str, TecsDirection | None],
    ) -> Sizes | None:
        if not parameter.given:
            return _NO_SIZES if parameter.good else None
        values: dict[str, Operand] = {}
        max_size: int | None = None
        for word in _LENGTHS:
            specifier = parameter.given.get(word)
            if specifier is None or not specifier.arguments:
                continue
            found = self._length(specifier, word, names)
            if found is None:
                parameter.good = False
                continue
            values[word] = found
            if found.value is None and not _tecsgen_knows(specifier.arguments[0]):
                message = f"tecsgen does not understand this argument of {word}"
                hint = "begin with the parameter, without parentheses: n * 2 + 1"
                self._report(rules.SIZE_FORM, specifier, message, hint)
            self._has_direction(parameter, word, specifier, found.model, directions)
            if word == "size_is" and len(specifier.arguments) > 1:
                max_size = self._limit(parameter, specifier, found)
        if not parameter.good:
            return None
        models = {word: operand.model for word, operand in values.items()}
        string = parameter.given.get("string")
        return Sizes(
            size_is=models.get("size_is"),
            max_size=max_size,
            count_is=models.get("count_is"),
            string=models.get("string"),
            unsized_string=string is not None and not string.arguments,
            nullable="nullable" in parameter.given,
        )

    def _length(
        self, specifier: tree.Specifier, word: str, names: dict[str, CType]
    ) -> Operand | None:
        written = specifier.arguments[0]
        assert not isinstance(written, tree.Name | tree.Allocation | tree.Restriction)
        found = self._types.expressions.operand(written, self._place, names)
        if found is None:
            return None
        found = whole_number(found)
        if found.operand_class not in (OperandClass.INTEGER, OperandClass.UNKNOWN):
            message = (
                f"the argument of {word} is an integer, not a {found.operand_class}"
            )
            hint = None
            if found.operand_class is OperandClass.POINTER and isinstance(
                found.model, Reference
            ):
                hint = f"write *{found.model}"
            self._report(rules.SIZE_TYPE, written, message, hint)
            return None
        if isinstance(found.value, int) and found.value <= 0:
            message = f"{word} is above zero, not {found.value}"
            self._report(rules.SIZE_SIGN, written, message)
            return None
        return found

    def _limit(
        self, parameter: _Parameter, specifier: tree.Specifier, size: Operand
    ) -> int | None:
        written = specifier.arguments[1]
        assert not isinstance(written, tree.Name | tree.Allocation | tree.Restriction)
        found = self._types.expressions.operand(written, self._place)
        limit = whole_number(found).value if found is not None else None
        if type(limit) is not int or limit <= 0:
            if found is not None:
                message = "the limit of size_is is a constant above zero"
                self._report(rules.MAX_SIZE, written, message)
            parameter.good = False
            return None
        if not isinstance(size.value, int):
            return limit
        if size.value >= limit:
            message = f"{size.value} is not below the limit {limit}"
            self._report(rules.SIZE_OVER_MAX, specifier, message)
            parameter.good = False
        else:
            message = f"the size is {size.value}, so the limit {limit} says nothing"
            self._report(rules.SIZE_UNDER_MAX, written, message, "leave it out")
        return None

    def _has_direction(
        self,
        parameter: _Parameter,
        word: str,
        specifier: tree.Specifier,
        length: Expression,
        directions: dict[str, TecsDirection | None],
    ) -> None:
        """Return whether the length's direction is suitable; as in tecsgen, for bare names only."""
        written = specifier.arguments[0]
        direction = parameter.direction
        if not isinstance(length, Reference) or direction is None:
            return
        way = directions.get(length.name)
        if way is None:
            return
        if direction is TecsDirection.RECEIVE or (
            word == "count_is" and direction is TecsDirection.OUT
        ):
            wanted: tuple[TecsDirection, ...] = _OUTWARD
        elif word == "count_is" and direction is TecsDirection.INOUT:
            wanted = (TecsDirection.INOUT,)
        else:
            wanted = _INWARD
        if way not in wanted:
            message = (
                f"'{length.name}' is {way}, but {word} of the {direction} parameter "
                f"'{parameter.name.text}' needs it to be {' or '.join(wanted)}"
            )
            assert not isinstance(written, tree.Allocation | tree.Restriction)
            self._report(rules.LENGTH_DIRECTION, written, message)
            parameter.good = False


def _tecsgen_knows(size: object) -> bool:
    """Return whether tecsgen can determine the type of a size that is not constant.

    It uses the type of the first operand, and supports only parameters, their targets, and
    arithmetic.
    """
    match size:
        case tree.ScopedName():
            return True
        case tree.Unary(operator="*", operand=operand):
            return isinstance(operand, tree.ScopedName)
        case tree.Unary(operator="+" | "-" | "~", operand=operand):
            return _tecsgen_knows(operand)
        case tree.Chain(first=first, rest=rest):
            return all(m in "+-*/%" for m, _ in rest) and _tecsgen_knows(first)
    return False


def _needed_levels(parameter: _Parameter) -> int:
    """Return the number of pointer levels that a parameter's direction and specifiers require."""
    given = parameter.given
    size = "size_is" in given or "count_is" in given
    string = "string" in given
    needed = 0 if parameter.direction is TecsDirection.IN else 1
    if size or string:
        needed = 2 if size and string else 1
    return needed + (parameter.direction is TecsDirection.RECEIVE)


def _target(type_: CType) -> CType:
    """Return the target type of all pointer levels."""
    for _ in range(pointer_depth(type_)):
        inner = resolve(type_)
        assert isinstance(inner, CPointerType)
        type_ = inner.target
    return type_


def _leads_to_struct(type_: CType) -> bool:
    found = resolve(type_)
    while isinstance(found, CPointerType):
        found = resolve(found.target)
    return isinstance(found, CStructType)
