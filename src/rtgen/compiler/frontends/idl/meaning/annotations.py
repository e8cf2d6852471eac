"""Annotations (OMG IDL 4.2, 7.4.15): allowed places, parameters, and arguments as values."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from decimal import Decimal
from typing import TypeGuard

from rtgen.compiler.diagnostics import Diagnostic, Related
from rtgen.compiler.frontends.idl.meaning.defaults import (
    DefaultError,
    enumerator_of,
    flags_of,
    items_of,
    shortest,
    words_of,
)
from rtgen.compiler.frontends.idl.meaning.typetable import PRIMITIVES, Types
from rtgen.compiler.frontends.idl.names.annotation_definitions import (
    _ANYWHERE,
    _REPEATABLE,
    DEFINITIONS,
    INTEGER,
    NUMBER,
    TEXT,
    TYPED,
    WORD,
    Definition,
    Wanted,
)
from rtgen.compiler.frontends.idl.names.scopes import Entity, Kind
from rtgen.compiler.frontends.idl.rules import annotations as rules
from rtgen.compiler.frontends.idl.rules import names as name_rules
from rtgen.compiler.frontends.idl.syntax import tree
from rtgen.compiler.frontends.idl.text.unit import Unit
from rtgen.compiler.frontends.kit.suggestions import Guesses, nearest
from rtgen.compiler.model import (
    Annotation,
    ArrayType,
    ConstantValue,
    EnumeratorName,
    InitialValue,
    Limits,
    NamedType,
    Primitive,
    SequenceType,
    StringType,
    Type,
)

_VALUES = (Kind.CONST, Kind.ENUMERATOR)


class Annotations:
    """Converts annotations of the tree into those of the model; diagnostics go to `report`."""

    def __init__(self, types: Types, report: Callable[[Diagnostic], None]) -> None:
        self._types = types
        self._report = report
        self._guesses = Guesses()

    def of(
        self,
        annotations: Iterable[tree.Annotation],
        place: str,
        unit: Unit,
        type_: Type | None = None,
    ) -> tuple[Annotation, ...]:
        """Return a declaration's annotations; `type_` is its type, for `@default` and similar."""
        nodes = tuple(annotations)
        if not nodes:
            return ()
        if len(nodes) > 1:
            self._repeated(nodes, unit)
        return tuple(self._one(a, place, unit, type_) for a in nodes)

    def initial(
        self,
        nodes: Iterable[tree.Annotation],
        annotations: Iterable[Annotation],
        type_: Type,
        unit: Unit,
    ) -> InitialValue | None:
        """Return the value of `@default` of a type; None without a valid one."""
        default = value(annotations, "default")
        plain = self._types.unaliased(type_)
        if default is None or not isinstance(plain, SequenceType | ArrayType):
            return default
        try:
            return items_of(self._types, plain, str(default))
        except DefaultError as error:
            node = next(node for node in nodes if node.name == "default")
            self._misfit(node.arguments[0].value, unit, error)
            return None

    def _misfit(self, node: tree.Expression, unit: Unit, error: DefaultError) -> None:
        span = unit.span(node.start, node.end)
        self._report(rules.DEFAULT_RANGE.at(span, str(error), hint=error.hint))

    def _repeated(self, nodes: tuple[tree.Annotation, ...], unit: Unit) -> None:
        seen: dict[str, tree.Annotation] = {}
        for node in nodes:
            statements = [node.name]
            if node.name == "range":
                statements += [each.name.text for each in node.arguments if each.name]
            for stated in statements:
                first = seen.setdefault(stated, node)
                if first is not node and stated not in _REPEATABLE:
                    before = unit.span(first.start, first.end)
                    self._report(
                        rules.REPEATED.at(
                            unit.span(node.start, node.end),
                            f"@{stated} is given twice",
                            related=[Related(before, "the first time")],
                            hint="keep one of them",
                        )
                    )
                    break

    def _one(
        self, node: tree.Annotation, place: str, unit: Unit, type_: Type | None
    ) -> Annotation:
        definition = DEFINITIONS.get(node.name) or self._declared(node.name)
        span = unit.span(node.start, node.end)
        if definition is None:
            near = self._guesses.nearest(node.name, DEFINITIONS)
            self._report(
                rules.UNKNOWN_ANNOTATION.at(
                    span,
                    f"@{node.name} is not known",
                    hint=(
                        f"did you mean @{near}?"
                        if near
                        else "it is kept, but has no effect"
                    ),
                )
            )
        elif place not in definition.places:
            message = f"@{node.name} means nothing for {_article(place)}"
            hint = f"it belongs to: {', '.join(sorted(definition.places))}"
            self._report(rules.MISPLACED.at(span, message, hint=hint))
        arguments: list[tuple[str, ConstantValue]] = []
        for argument in node.arguments:
            key = argument.name.text if argument.name else "value"
            value = self._argument(node, key, argument.value, definition, unit, type_)
            if any(key == other for other, _ in arguments):
                again = unit.span(argument.value.start, argument.value.end)
                message = f"'{key}' is given twice"
                hint = "keep one of them"
                self._report(rules.BAD_ARGUMENT.at(again, message, hint=hint))
            elif value is not None:
                arguments.append((key, value))
        if definition is not None and not _complete(node, definition):
            needed = definition.required
            alone = needed == "value"
            hint = f"write @{node.name}({'VALUE' if alone else f'{needed}=...'})"
            message = f"@{node.name} needs {'an argument' if alone else needed}"
            self._report(rules.BAD_ARGUMENT.at(span, message, hint=hint))
        return Annotation(node.name, tuple(arguments))

    def _declared(self, name: str) -> Definition | None:
        """Return an annotation declared by `@annotation`, which is allowed everywhere."""
        members = self._types.tables.annotations.get(name)
        if members is None:
            return None
        return Definition(dict.fromkeys(members, WORD), frozenset(_ANYWHERE.split()))

    def _argument(
        self,
        node: tree.Annotation,
        key: str,
        value: tree.Expression,
        definition: Definition | None,
        unit: Unit,
        type_: Type | None,
    ) -> ConstantValue | None:
        parameter_type: Wanted | None = None
        if definition is not None:
            if key not in definition.arguments:
                near = nearest(key, definition.arguments)
                names = ", ".join(definition.arguments) or "none"
                self._report(
                    rules.BAD_ARGUMENT.at(
                        unit.span(value.start, value.end),
                        f"@{node.name} has no argument '{key}'",
                        hint=(
                            f"did you mean {near}?"
                            if near
                            else f"its arguments: {names}"
                        ),
                    )
                )
                return None
            parameter_type = definition.arguments[key]
        if parameter_type == TYPED:
            plain = self._types.unaliased(type_)
            if isinstance(plain, NamedType):
                return self._named(value, plain, unit)
            parameter_type = self._scalar(type_)
        if parameter_type is None or isinstance(parameter_type, str):
            words = definition.words.get(key, ()) if definition is not None else ()
            return self._word(node, value, words, unit)
        constant = self._evaluated(value, parameter_type, unit)
        single = self._types.unaliased(parameter_type) == PRIMITIVES[Primitive.FLOAT]
        return (
            shortest(constant) if single and isinstance(constant, float) else constant
        )

    def _word(
        self,
        node: tree.Annotation,
        value: tree.Expression,
        words: tuple[str, ...],
        unit: Unit,
    ) -> ConstantValue | None:
        """Return an argument without a type: one of `words`, or several joined by `|`."""
        if words and isinstance(value, tree.Chain):
            parts = [value.first, *(operand for _, operand in value.rest)]
            words_read = [self._word(node, part, words, unit) for part in parts]
            return None if None in words_read else "|".join(map(str, words_read))
        if isinstance(value, tree.ScopedName) and _last(value) in words:
            return str(value)  # not looked up, even if it is declared
        natural = self.natural(value, unit)
        if not words or str(natural).upper().replace("-", "_") in words:
            return natural
        near = nearest(str(natural), words)
        possible = f"one of {', '.join(words)}"
        self._report(
            rules.BAD_ARGUMENT.at(
                unit.span(value.start, value.end),
                f"@{node.name} cannot be {natural}",
                hint=(
                    f"did you mean {near}? It is {possible}"
                    if near
                    else f"write {possible}"
                ),
            )
        )
        return None

    def _named(
        self, value: tree.Expression, type_: NamedType, unit: Unit
    ) -> ConstantValue | None:
        """Return an enumerator, which need not be qualified, or the flags of a bitmask."""
        if self._types.kind_of(type_) is Kind.BITMASK:
            try:
                return flags_of(self._types, type_, value)
            except DefaultError as error:
                self._misfit(value, unit, error)
                return None
        if isinstance(value, tree.ScopedName) and len(value.parts) == 1:
            entity = self._types.tables.references.get(value)
            if not (isinstance(entity, Entity) and entity.kind in _VALUES):
                enumerator = enumerator_of(self._types, type_, value.parts[0].text)
                if enumerator is not None:
                    return enumerator
        return self._evaluated(value, type_, unit)

    def _evaluated(
        self, value: tree.Expression, type_: Type, unit: Unit
    ) -> ConstantValue | None:
        """Return the value of an expression, reporting the names that are unknown."""
        unknown = [name for name in tree.parts_of(value) if self._is_unknown(name)]
        for name in unknown:
            message = f"{name} is unknown"
            near = nearest(str(name), words_of(self._types, type_))
            hint = "declare it before its use, or include the file that declares it"
            if near:
                hint = f"did you mean {near}?"
            span = unit.span(name.start, name.end)
            self._report(name_rules.UNKNOWN_NAME.at(span, message, hint=hint))
        if unknown:
            return None
        return self._types.constants.evaluate(value, type_, unit, "argument")

    def _is_unknown(self, part: tree.Expression) -> TypeGuard[tree.ScopedName]:
        """Return whether an expression is a name that was not found."""
        references = self._types.tables.references
        return isinstance(part, tree.ScopedName) and references.get(part) is None

    def _scalar(self, type_: Type | None) -> Type | None:
        """Return the type of a default value; the default of a list is a text."""
        plain = self._types.unaliased(type_)
        if (
            plain is None
            or plain in PRIMITIVES.values()
            or isinstance(plain, StringType)
        ):
            return type_
        if type(plain).__name__ in ("SequenceType", "ArrayType"):
            return TEXT
        return type_

    def natural(self, value: tree.Expression, unit: Unit) -> ConstantValue | None:
        """Return the value of an argument of unknown type, as its literal suggests."""
        constants = self._types.constants
        match value:
            case tree.ScopedName():
                entity = self._types.tables.references.get(value)
                if isinstance(entity, Entity) and entity.kind is Kind.ENUMERATOR:
                    return EnumeratorName(entity.path)
                if isinstance(entity, Entity) and entity.kind is Kind.CONST:
                    return constants.value_of(entity)
                return str(value)
            case tree.Text(parts, character):
                wide = parts[0].startswith("L")
                kind = Primitive.WCHAR if wide else Primitive.CHAR
                type_: Type = PRIMITIVES[kind] if character else StringType(wide)
                return constants.evaluate(value, type_, unit, "argument")
            case tree.Boolean(flag):
                return flag
        type_ = NUMBER if _has_point(value) else INTEGER
        return constants.evaluate(value, type_, unit, "argument")


def _last(name: tree.ScopedName) -> str:
    return name.parts[-1].text.upper()


def _complete(node: tree.Annotation, definition: Definition) -> bool:
    """Return whether the mandatory argument is present, valid or not."""
    names = [a.name.text if a.name else "value" for a in node.arguments]
    return (
        not definition.required
        or definition.required in names
        or not definition.arguments.keys() >= set(names)
    )


def contradictions(within: Limits, default: InitialValue | None) -> Iterator[str]:
    """Yield contradictions between a default, or its items, and its limits."""
    low, high = within
    if exceeds(low, high):
        yield f"the minimum {low} is larger than the maximum {high}"
    for item in default if isinstance(default, tuple) else (default,):
        if exceeds(low, item):
            yield f"the default {item} is below the minimum {low}"
        if exceeds(item, high):
            yield f"the default {item} is above the maximum {high}"


def _has_point(node: tree.Expression) -> bool:
    return any(
        not part.text.isdigit() and part.text[1:2] not in ("x", "X")
        for part in tree.parts_of(node)
        if isinstance(part, tree.Number)
    )


def _article(place: str) -> str:
    return f"{'an' if place[0] in 'aeiou' else 'a'} {place}"


def flag(annotations: Iterable[Annotation], name: str) -> bool:
    """Return whether an annotation such as `@key` is present and not FALSE."""
    for annotation in annotations:
        if annotation.name == name:
            return annotation.get() is not False
    return False


def integer(annotations: Iterable[Annotation], name: str) -> int | None:
    """Return the integer argument of an annotation such as `@id(3)`."""
    found = (each.get() for each in annotations if each.name == name)
    return next((each for each in found if isinstance(each, int)), None)


def text(annotations: Iterable[Annotation], name: str) -> str | None:
    """Return the text argument of an annotation such as `@unit("m")`."""
    found = (each.get() for each in annotations if each.name == name)
    return next((each for each in found if isinstance(each, str)), None)


def value(
    annotations: Iterable[Annotation], name: str, key: str = "value"
) -> ConstantValue | None:
    """Return the value of an argument of the first annotation with this name."""
    return next((a.get(key) for a in annotations if a.name == name), None)


def exceeds(left: ConstantValue | None, right: ConstantValue | None) -> bool:
    """Return whether both are numbers, and the left one is greater."""
    if isinstance(left, int | float) and isinstance(right, int | float):
        return left > right
    return isinstance(left, Decimal) and isinstance(right, Decimal) and left > right
