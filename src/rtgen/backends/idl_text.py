"""Prints OMG IDL from a model; the IDL front end can read the result.

Only the content of the model is written: constants are evaluated, macros are gone. Homes are
omitted, and components unless requested, so that other IDL compilers can read the result; with
`annotations` they have to support IDL 4.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from decimal import Decimal

from rtgen.backends.quoting.idl import (
    characters,
    comment_lines,
    readable_string,
    repository_id,
)
from rtgen.model import (
    Annotation,
    ArrayType,
    Attribute,
    Bitfield,
    Bitmask,
    Bitset,
    Case,
    ConfigurationParameter,
    Const,
    ConstantValue,
    Declaration,
    Documented,
    Enum,
    EnumeratorName,
    ExceptionDecl,
    FixedType,
    Home,
    Interface,
    MapType,
    Member,
    Model,
    NamedType,
    Native,
    Operation,
    Port,
    PortKind,
    Primitive,
    PrimitiveType,
    ScopedName,
    SequenceType,
    StringType,
    Struct,
    Type,
    Typedef,
    Union,
    ValueBox,
    Valuetype,
)
from rtgen.model.components import Component
from rtgen.typemap.component_annotations import annotations_of
from rtgen.typemap.idl_words import escaped
from rtgen.typemap.implementation_modules import referred

_STEP = "    "
_INLINE = (Struct, Union, ExceptionDecl)
"""Declarations whose member types may be declared in place."""

_PORTS = {
    PortKind.INPORT: "consumes",
    PortKind.OUTPORT: "publishes",
    PortKind.PROVIDER: "provides",
    PortKind.CONSUMER: "uses",
}

_TYPED = ("default", "min", "max")
"""Annotations whose argument is a value of the annotated type."""


def idl_text(
    model: Model,
    declarations: Iterable[Declaration],
    *,
    annotations: bool = True,
    components: bool = False,
    guard: Callable[[Declaration], str] = lambda declaration: "",
) -> str:
    """Print declarations as IDL, opening and closing modules as necessary.

    Other declarations of the model are assumed to come from included files. `guard` returns the
    macro that protects a declaration contained in several files; empty for none. Nested
    declarations are printed with the enclosing one.
    """
    declarations = tuple(declarations)
    writer = _Writer(model, annotations, declarations)
    parts: list[str] = []
    scope: ScopedName = ()
    for declaration in declarations:
        left_out = (Home,) if components else (Home, Component)
        if isinstance(declaration, left_out) or writer.is_inner(declaration):
            continue
        macro = guard(declaration)
        wanted = declaration.name[:-1]
        if macro:
            parts += [*_to(scope, ()), f"#ifndef {macro}\n#define {macro}\n"]
            scope = ()
        parts += _to(scope, wanted)
        scope = wanted
        parts += writer.top(declaration)
        if macro:
            parts += [*_to(scope, ()), f"#endif // {macro}\n"]
            scope = ()
    parts += _to(scope, ())
    return "\n".join(parts)


def literal(model: Model, type_: Type, value: ConstantValue) -> str:
    """A constant's value as IDL writes it for that type."""
    type_ = model.unalias(type_)
    wide = type_ == PrimitiveType(Primitive.WCHAR)
    wide |= isinstance(type_, StringType) and type_.wide
    match value:
        case bool():
            return "TRUE" if value else "FALSE"
        case EnumeratorName(name):
            return "::".join(map(escaped, name))
        case str():
            is_text = isinstance(type_, StringType)
            quote = '"' if is_text else "'"
            return f"{'L' if wide else ''}{quote}{characters(value, wide)}{quote}"
        case float():
            return _float(value)
        case Decimal():
            return f"{value:f}d"
        case int() if _is_floating(type_):
            return _float(float(value))
    return str(value)


def _is_floating(type_: Type) -> bool:
    floating = (Primitive.FLOAT, Primitive.DOUBLE, Primitive.LONG_DOUBLE)
    return isinstance(type_, PrimitiveType) and type_.kind in floating


def _float(value: float) -> str:
    if value in (float("inf"), float("-inf")):
        return "1e999" if value > 0 else "-1e999"
    return repr(value)


def _to(scope: ScopedName, wanted: ScopedName) -> Iterator[str]:
    """The lines between two modules."""
    common = 0
    while common < min(len(scope), len(wanted)) and scope[common] == wanted[common]:
        common += 1
    for depth in range(len(scope), common, -1):
        yield f"{_STEP * (depth - 1)}}};\n"
    for depth in range(common, len(wanted)):
        yield f"{_STEP * depth}module {escaped(wanted[depth])} {{\n"


class _Writer:
    def __init__(
        self, model: Model, annotations: bool, declarations: Sequence[Declaration]
    ) -> None:
        self._model = model
        self._with_annotations = annotations
        self._names = {declaration.name for declaration in model.declarations}
        self._own = {declaration.name for declaration in declarations}
        self._done: set[ScopedName] = set()
        self._bound_names: dict[ScopedName, frozenset[str]] = {}
        self._inside: dict[ScopedName, list[Declaration]] = {}
        for declaration in model.declarations:
            if self.is_inner(declaration):
                inner = self._inside.setdefault(declaration.name[:-1], [])
                inner.append(declaration)

    def _is_written(self, name: ScopedName) -> bool:
        """Whether it is declared before: here, or by what is not to be written."""
        prefixes = (name[:depth] for depth in range(1, len(name) + 1))
        return name in self._done or (
            name in self._names and self._own.isdisjoint(prefixes)
        )

    def is_inner(self, declaration: Declaration) -> bool:
        """Whether it is nested in another declaration."""
        return declaration.name[:-1] in self._names

    def top(self, declaration: Declaration) -> Iterator[str]:
        """Print a declaration in its module, after its dependencies."""
        depth = len(declaration.name) - 1
        for name in self._forward(declaration):
            yield _indented([f"{self._kind(name)} {escaped(name[-1])};"], depth)
        lines = list(self._declaration(declaration))
        yield _indented(lines, depth)

    def _forward(self, declaration: Declaration) -> Iterator[ScopedName]:
        """Dependencies in the same module that have not been printed yet."""
        inner = self._inside.get(declaration.name, ())
        for name in dict.fromkeys(
            n for d in (declaration, *inner) for n in referred(d)
        ):
            other = self._model.find(name) if name in self._names else None
            if self._is_written(name) or name == declaration.name:
                continue
            if name[:-1] == declaration.name[:-1] and isinstance(
                other, Interface | Valuetype | Struct | Union
            ):
                self._done.add(name)
                yield name

    def _kind(self, name: ScopedName) -> str:
        declaration = self._model.find(name)
        words = []
        if isinstance(declaration, Interface | Valuetype) and declaration.abstract:
            words.append("abstract")
        if isinstance(declaration, Interface):
            words += ["local"] * declaration.local + ["interface"]
        elif isinstance(declaration, Valuetype):
            words.append("eventtype" if declaration.eventtype else "valuetype")
        else:
            words.append("struct" if isinstance(declaration, Struct) else "union")
        return " ".join(words)

    # Declarations, as lines without their module's indentation.

    def _declaration(self, declaration: Declaration) -> Iterator[str]:
        self._done.add(declaration.name)
        yield from self._above(declaration)
        lines = list(self._definition(declaration))
        lines[-1] += ";"
        yield from lines
        yield from self._repository_id(declaration)

    def _repository_id(self, declaration: Declaration) -> Iterator[str]:
        text = declaration.repository_id
        if text and text != _default_id(declaration.name):
            name = "::".join(map(escaped, declaration.name))
            yield repository_id(name, text)

    def _definition(self, declaration: Declaration) -> Iterator[str]:
        """The text up to the semicolon."""
        name = escaped(declaration.name[-1])
        scope = declaration.name[:-1]
        match declaration:
            case Struct(base=base, members=members):
                inherits = f" : {self._name(base, scope)}" if base else ""
                yield from self._braced(
                    f"struct {name}{inherits}", self._members(members, declaration.name)
                )
            case ExceptionDecl(members=members):
                body = self._members(members, declaration.name)
                yield from self._braced(f"exception {name}", body)
            case Union(switch=switch):
                head = f"union {name} switch ({self._type(switch, declaration.name)})"
                yield from self._braced(head, self._cases(declaration))
            case Enum() | Bitmask():
                yield from self._enumerated(declaration)
            case Bitset(base=base, members=fields):
                inherits = f" : {self._name(base, scope)}" if base else ""
                body = (line for f in fields for line in self._bitfield(f, scope))
                yield from self._braced(f"bitset {name}{inherits}", body)
            case Typedef(type=type_):
                yield f"typedef {self._declarator(type_, name, scope)}"
            case Const(type=type_, value=value):
                text = literal(self._model, type_, value)
                yield f"const {self._type(type_, scope)} {name} = {text}"
            case Native():
                yield f"native {name}"
            case ValueBox(type=type_):
                yield f"valuetype {name} {self._type(type_, scope)}"
            case Interface():
                yield from self._interface(declaration)
            case Valuetype():
                yield from self._valuetype(declaration)
            case Component():
                yield from self._component(declaration)
            case _:
                raise TypeError(f"no IDL for {type(declaration).__name__}")

    def _braced(self, head: str, body: Iterable[str]) -> Iterator[str]:
        yield f"{head} {{"
        yield from (f"{_STEP}{line}" if line else "" for line in body)
        yield "}"

    def _members(self, members: Sequence[Member], scope: ScopedName) -> Iterator[str]:
        for member in members:
            yield from self._above(member)
            yield f"{self._declarator(member.type, escaped(member.name), scope)};"

    def _cases(self, union: Union) -> Iterator[str]:
        for case in union.cases:
            yield from self._labels(union, case)
            yield from (f"{_STEP}{line}" for line in self._above(case))
            text = self._declarator(case.type, escaped(case.name), union.name)
            yield f"{_STEP}{text};".replace("\n", f"\n{_STEP}")

    def _labels(self, union: Union, case: Case) -> Iterator[str]:
        for label in case.labels:
            yield f"case {literal(self._model, union.switch, label)}:"
        if case.default:
            yield "default:"

    def _enumerated(self, declaration: Enum | Bitmask) -> Iterator[str]:
        is_enum = isinstance(declaration, Enum)
        head = f"{'enum' if is_enum else 'bitmask'} {escaped(declaration.name[-1])}"
        body: list[str] = []
        last = len(declaration.members) - 1
        for place, member in enumerate(declaration.members):
            body += self._above(member)
            body.append(escaped(member.name) + ("," if place < last else ""))
        yield from self._braced(head, body)

    def _bitfield(self, field: Bitfield, scope: ScopedName) -> Iterator[str]:
        yield from self._above(field)
        type_ = "" if field.type is None else f",{self._type(field.type, scope)}"
        name = "" if field.name is None else f" {escaped(field.name)}"
        yield f"bitfield<{field.bits}{type_}>{name};"

    def _interface(self, declaration: Interface) -> Iterator[str]:
        head = f"{self._kind(declaration.name)} {escaped(declaration.name[-1])}"
        if declaration.forward:
            yield head
            return
        scope = declaration.name[:-1]
        if declaration.bases:
            bases = (self._name(base, scope) for base in declaration.bases)
            head += f" : {', '.join(bases)}"
        yield from self._braced(head, self._exports(declaration))

    def _valuetype(self, declaration: Valuetype) -> Iterator[str]:
        head = f"{self._kind(declaration.name)} {escaped(declaration.name[-1])}"
        if declaration.forward:
            yield head
            return
        scope = declaration.name[:-1]
        if declaration.custom:
            head = f"custom {head}"
        bases = [self._name(base, scope) for base in declaration.bases]
        if bases:
            cut = "truncatable " if declaration.truncatable else ""
            head += f" : {cut}{', '.join(bases)}"
        if declaration.supports:
            supported = (self._name(name, scope) for name in declaration.supports)
            head += f" supports {', '.join(supported)}"
        yield from self._braced(head, self._exports(declaration))

    def _component(self, component: Component) -> Iterator[str]:
        scope = component.name[:-1]
        head = f"component {escaped(component.name[-1])}"
        if component.base is not None:
            head += f" : {self._name(component.base, scope)}"
        if component.supports:
            supported = (self._name(name, scope) for name in component.supports)
            head += f" supports {', '.join(supported)}"
        yield from self._braced(head, self._items(component))

    def _items(self, component: Component) -> Iterator[str]:
        """Ports and parameters, without inherited ones."""
        inherited: frozenset[Port | ConfigurationParameter] = frozenset()
        if component.base is not None:
            base = self._model.find(component.base)
            assert isinstance(base, Component)
            inherited = frozenset((*base.ports, *base.configuration))
        scope = component.name[:-1]
        items: Sequence[Port | ConfigurationParameter]
        items = [*component.ports, *component.configuration]
        for item in items:
            if item in inherited:
                continue
            yield from self._above(item)
            name = escaped(item.identifier)
            if isinstance(item, Port):
                yield f"{_PORTS[item.kind]} {self._type(item.type, scope)} {name};"
            else:
                yield f"attribute {self._declarator(item.type, name, scope)};"

    def _exports(self, declaration: Interface | Valuetype) -> Iterator[str]:
        scope = declaration.name
        for inner in self._inside.get(scope, ()):
            if not self._is_written(inner.name):
                yield from self._declaration(inner)
        if isinstance(declaration, Valuetype):
            for member in declaration.state:
                yield from self._above(member)
                access = "public" if member.public else "private"
                text = self._declarator(member.type, escaped(member.name), scope)
                yield f"{access} {text};"
            for factory in declaration.factories:
                yield from self._above(factory)
                yield f"factory {self._call(factory, scope)};"
        for attribute in declaration.attributes:
            yield from self._attribute(attribute, scope)
        for operation in declaration.operations:
            yield from self._above(operation)
            oneway = "oneway " if operation.oneway else ""
            returns = self._type(operation.returns, scope)
            yield f"{oneway}{returns} {self._call(operation, scope)};"
            yield from self._inner_id(declaration, operation)

    def _attribute(self, attribute: Attribute, scope: ScopedName) -> Iterator[str]:
        yield from self._above(attribute)
        readonly = "readonly " if attribute.readonly else ""
        text = f"{readonly}attribute {self._type(attribute.type, scope)} {escaped(attribute.name)}"
        get = self._raises(attribute.get_raises, scope)
        if attribute.readonly:
            text += f" raises {get}" if get else ""
        else:
            put = self._raises(attribute.set_raises, scope)
            text += f" getraises {get}" if get else ""
            text += f" setraises {put}" if put else ""
        yield f"{text};"
        yield from self._inner_id(self._model.find(scope), attribute)

    def _inner_id(
        self, holder: Declaration, entry: Operation | Attribute
    ) -> Iterator[str]:
        text = entry.repository_id
        if text and text != _default_id((*holder.name, entry.name)):
            name = "::".join(map(escaped, (*holder.name, entry.name)))
            yield repository_id(name, text)

    def _call(self, operation: Operation, scope: ScopedName) -> str:
        names = [p.name for p in operation.parameters]
        parameters = (
            f"{p.direction.value} {self._type(p.type, scope, names)} {escaped(p.name)}"
            for p in operation.parameters
        )
        text = f"{escaped(operation.name)}({', '.join(parameters)})"
        raised = self._raises(operation.raises, scope)
        text += f" raises {raised}" if raised else ""
        if operation.context:
            contexts = ", ".join(map(readable_string, operation.context))
            text += f" context ({contexts})"
        return text

    def _raises(self, names: Sequence[ScopedName], scope: ScopedName) -> str:
        listed = ", ".join(self._name(name, scope) for name in names)
        return f"({listed})" if listed else ""

    # What stands above a declaration or member.

    def _above(self, entry: Documented) -> Iterator[str]:
        doc = comment_lines(entry.doc)
        if len(doc) == 1:
            yield f"/** {doc[0]} */"
        elif doc:
            yield "/**"
            yield from (f" * {line}".rstrip() for line in doc)
            yield " */"
        if self._with_annotations:
            for annotation in entry.annotations or annotations_of(entry):
                yield self._annotation(annotation, getattr(entry, "type", None))

    def _annotation(self, annotation: Annotation, of: Type | None) -> str:
        values = [
            (key, self._argument(value, of if annotation.name in _TYPED else None))
            for key, value in annotation.arguments
        ]
        if [key for key, _ in values] == ["value"]:
            return f"@{annotation.name}({values[0][1]})"
        inside = ", ".join(f"{key}={text}" for key, text in values)
        return f"@{annotation.name}({inside})" if inside else f"@{annotation.name}"

    def _argument(self, value: ConstantValue, type_: Type | None) -> str:
        """An argument of an annotation, as its own kind of value or as one of the type."""
        plain = None if type_ is None else self._model.unalias(type_)
        if isinstance(value, str):
            wide = plain in (StringType(wide=True), PrimitiveType(Primitive.WCHAR))
            if not wide:
                return readable_string(value)
            return literal(self._model, StringType(wide=True), value)
        if plain is None or isinstance(plain, SequenceType | ArrayType):
            plain = PrimitiveType(
                Primitive.DOUBLE if isinstance(value, float) else Primitive.LONG
            )
        return literal(self._model, plain, value)

    # Types.

    def _declarator(self, type_: Type, name: str, scope: ScopedName) -> str:
        """`type name`, with the dimensions of an array behind the name."""
        if isinstance(type_, ArrayType):
            dimensions = "".join(f"[{size}]" for size in type_.dimensions)
            return f"{self._type(type_.element, scope)} {name}{dimensions}"
        return f"{self._type(type_, scope)} {name}"

    def _type(
        self, type_: Type, scope: ScopedName, beside: Collection[str] = ()
    ) -> str:
        """A type where `beside` is the name of what has it."""
        match type_:
            case PrimitiveType(kind):
                return kind.value
            case StringType(wide, bound):
                word = "wstring" if wide else "string"
                return word if bound is None else f"{word}<{bound}>"
            case FixedType(digits, scale):
                return f"fixed<{digits},{scale}>" if digits else "fixed"
            case SequenceType(element, bound):
                text = self._type(element, scope, beside)
                end = "" if bound is None else f",{bound}"
                gap = " " if not end and text.endswith(">") else ""
                return f"sequence<{text}{end}{gap}>"
            case MapType(key, value, bound):
                text = f"{self._type(key, scope)},{self._type(value, scope)}"
                end = "" if bound is None else f",{bound}"
                gap = " " if not end and text.endswith(">") else ""
                return f"map<{text}{end}{gap}>"
            case ArrayType():
                raise TypeError("an array has to be declared")
            case NamedType(name):
                return self._reference(name, scope, beside)

    def _reference(
        self, name: ScopedName, scope: ScopedName, beside: Collection[str]
    ) -> str:
        """A use of a type, or its definition at its first use if it is declared in place."""
        holder = self._model.find(scope) if scope in self._names else None
        if (
            isinstance(holder, _INLINE)
            and name[:-1] == scope
            and not self._is_written(name)
        ):
            self._done.add(name)
            lines = self._definition(self._model.find(name))
            return "\n".join(lines).replace("\n", f"\n{_STEP}")
        return self._name(name, scope, beside)

    def _name(
        self, name: ScopedName, scope: ScopedName, beside: Collection[str] = ()
    ) -> str:
        """A scoped name, absolute if its first part is hidden here.

        A name that is used is also introduced into the scope (CORBA 2.6, 3.15.3).
        """
        text = "::".join(map(escaped, name))
        first = name[0].lower()
        taken = first in {other.lower() for other in beside} or any(
            first in self._bound(scope[:depth]) for depth in range(1, len(scope) + 1)
        )
        return f"::{text}" if taken else text

    def _bound(self, scope: ScopedName) -> frozenset[str]:
        """The names, in lower case, that a scope binds."""
        found = self._bound_names.get(scope)
        if found is None:
            depth = len(scope)
            names = {
                name[depth].lower()
                for name in self._names
                if len(name) > depth and name[:depth] == scope
            }
            if scope in self._names:
                names.update(map(str.lower, _parts(self._model.find(scope))))
            found = self._bound_names[scope] = frozenset(names)
        return found


def _default_id(name: ScopedName) -> str:
    return f"IDL:{'/'.join(name)}:1.0"


def _indented(lines: Iterable[str], depth: int) -> str:
    """The lines at the depth of their module, with an empty one behind."""
    text = "\n".join(lines)
    margin = _STEP * depth
    indented = (
        line if line.startswith("#") or not line else margin + line
        for line in text.split("\n")
    )
    return "\n".join(indented) + "\n"


def _parts(declaration: Declaration) -> Iterator[str]:
    """The names of what a declaration consists of."""
    match declaration:
        case Struct(members=members) | ExceptionDecl(members=members):
            yield from (member.name for member in members)
        case Union(cases=cases):
            yield from (case.name for case in cases)
        case Interface() | Valuetype():
            yield from (attribute.name for attribute in declaration.attributes)
            yield from (operation.name for operation in declaration.operations)
            if isinstance(declaration, Valuetype):
                yield from (member.name for member in declaration.state)
                yield from (factory.name for factory in declaration.factories)
