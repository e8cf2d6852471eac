"""Declarations as IDL text (OMG IDL 4.2, 7.4), without the modules around them."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence

from rtgen.compiler.backends.kit.idl_text.literals import literal
from rtgen.compiler.backends.kit.idl_text.scopes import ScopedNames
from rtgen.compiler.backends.kit.quoting.idl import (
    comment_lines,
    readable_string,
    repository_id,
)
from rtgen.compiler.model import (
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
    ExceptionDecl,
    FixedType,
    Interface,
    MapType,
    Member,
    Model,
    NamedType,
    Native,
    Operation,
    Parameter,
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
    default_id,
)
from rtgen.compiler.model.components import Component
from rtgen.compiler.typemap.components.annotations import annotations_of
from rtgen.compiler.typemap.python.implementation_modules import referred

STEP = "    "
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


class Writer:
    """Prints declarations; without `annotations` the text is IDL 3."""

    def __init__(self, model: Model, annotations: bool, names: ScopedNames) -> None:
        self._model = model
        self._escaped = names.escape
        self._with_annotations = annotations
        self._names = names

    def top(self, declaration: Declaration) -> Iterator[str]:
        """Print a declaration in its module, after its dependencies."""
        depth = len(declaration.name) - 1
        for name in self._forward(declaration):
            yield _indented([f"{self._kind(name)} {self._escaped(name[-1])};"], depth)
        lines = list(self._declaration(declaration))
        yield _indented(lines, depth)

    def _forward(self, declaration: Declaration) -> Iterator[ScopedName]:
        """Yield dependencies in the same module that have not been printed yet."""
        inner = self._names.inside(declaration.name)
        for name in dict.fromkeys(
            n for d in (declaration, *inner) for n in referred(d)
        ):
            other = self._model.find(name) if name in self._names else None
            if self._names.is_written(name) or name == declaration.name:
                continue
            if name[:-1] == declaration.name[:-1] and isinstance(
                other, Interface | Valuetype | Struct | Union
            ):
                self._names.done.add(name)
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
        self._names.done.add(declaration.name)
        yield from self._above(declaration)
        lines = list(self._definition(declaration))
        lines[-1] += ";"
        yield from lines
        yield from self._repository_id(declaration.name, declaration.repository_id)

    def _repository_id(self, name: ScopedName, text: str) -> Iterator[str]:
        if text and text != default_id(name):
            yield repository_id("::".join(map(self._escaped, name)), text)

    def _definition(self, declaration: Declaration) -> Iterator[str]:
        """Yield the text up to the semicolon."""
        name = self._escaped(declaration.name[-1])
        scope = declaration.name[:-1]
        match declaration:
            case Struct(base=base, members=members):
                inherits = f" : {self._names.text(base, scope)}" if base else ""
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
                inherits = f" : {self._names.text(base, scope)}" if base else ""
                body = (line for f in fields for line in self._bitfield(f, scope))
                yield from self._braced(f"bitset {name}{inherits}", body)
            case Typedef(type=type_):
                yield f"typedef {self._declarator(type_, name, scope)}"
            case Const(type=type_, value=value):
                text = self._literal(type_, value)
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
        yield from (f"{STEP}{line}" if line else "" for line in body)
        yield "}"

    def _members(self, members: Sequence[Member], scope: ScopedName) -> Iterator[str]:
        for member in members:
            yield from self._above(member)
            yield f"{self._declarator(member.type, self._escaped(member.name), scope)};"

    def _cases(self, union: Union) -> Iterator[str]:
        for case in union.cases:
            yield from self._labels(union, case)
            yield from (f"{STEP}{line}" for line in self._above(case))
            text = self._declarator(case.type, self._escaped(case.name), union.name)
            yield f"{STEP}{text};".replace("\n", f"\n{STEP}")

    def _labels(self, union: Union, case: Case) -> Iterator[str]:
        for label in case.labels:
            yield f"case {self._literal(union.switch, label)}:"
        if case.default:
            yield "default:"

    def _enumerated(self, declaration: Enum | Bitmask) -> Iterator[str]:
        is_enum = isinstance(declaration, Enum)
        head = (
            f"{'enum' if is_enum else 'bitmask'} {self._escaped(declaration.name[-1])}"
        )
        body: list[str] = []
        last = len(declaration.members) - 1
        for place, member in enumerate(declaration.members):
            body += self._above(member)
            body.append(self._escaped(member.name) + ("," if place < last else ""))
        yield from self._braced(head, body)

    def _bitfield(self, field: Bitfield, scope: ScopedName) -> Iterator[str]:
        yield from self._above(field)
        type_ = "" if field.type is None else f",{self._type(field.type, scope)}"
        name = "" if field.name is None else f" {self._escaped(field.name)}"
        yield f"bitfield<{field.bits}{type_}>{name};"

    def _interface(self, declaration: Interface) -> Iterator[str]:
        head = f"{self._kind(declaration.name)} {self._escaped(declaration.name[-1])}"
        if declaration.forward:
            yield head
            return
        head += self._listed(" : ", declaration.bases, declaration.name[:-1])
        yield from self._braced(head, self._exports(declaration))

    def _valuetype(self, declaration: Valuetype) -> Iterator[str]:
        head = f"{self._kind(declaration.name)} {self._escaped(declaration.name[-1])}"
        if declaration.forward:
            yield head
            return
        scope = declaration.name[:-1]
        if declaration.custom:
            head = f"custom {head}"
        colon = " : truncatable " if declaration.truncatable else " : "
        head += self._listed(colon, declaration.bases, scope)
        head += self._listed(" supports ", declaration.supports, scope)
        yield from self._braced(head, self._exports(declaration))

    def _component(self, component: Component) -> Iterator[str]:
        scope = component.name[:-1]
        bases = () if component.base is None else (component.base,)
        head = f"component {self._escaped(component.name[-1])}"
        head += self._listed(" : ", bases, scope)
        head += self._listed(" supports ", component.supports, scope)
        yield from self._braced(head, self._items(component))

    def _listed(
        self, word: str, names: Sequence[ScopedName], scope: ScopedName, end: str = ""
    ) -> str:
        """Return names after a word; nothing without names."""
        listed = ", ".join(self._names.text(name, scope) for name in names)
        return f"{word}{listed}{end}" if listed else ""

    def _items(self, component: Component) -> Iterator[str]:
        """Yield ports and parameters, without inherited ones."""
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
            name = self._escaped(item.identifier)
            if isinstance(item, Port):
                yield f"{_PORTS[item.kind]} {self._type(item.type, scope)} {name};"
            else:
                yield f"attribute {self._declarator(item.type, name, scope)};"

    def _exports(self, declaration: Interface | Valuetype) -> Iterator[str]:
        scope = declaration.name
        for inner in self._names.inside(scope):
            if not self._names.is_written(inner.name):
                yield from self._declaration(inner)
        if isinstance(declaration, Valuetype):
            for member in declaration.state:
                yield from self._above(member)
                access = "public" if member.public else "private"
                text = self._declarator(member.type, self._escaped(member.name), scope)
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
            yield from self._repository_id(
                (*scope, operation.name), operation.repository_id
            )

    def _attribute(self, attribute: Attribute, scope: ScopedName) -> Iterator[str]:
        yield from self._above(attribute)
        readonly = "readonly " if attribute.readonly else ""
        name = self._escaped(attribute.name)
        text = f"{readonly}attribute {self._type(attribute.type, scope)} {name}"
        if attribute.readonly:
            text += self._listed(" raises (", attribute.get_raises, scope, ")")
        else:
            text += self._listed(" getraises (", attribute.get_raises, scope, ")")
            text += self._listed(" setraises (", attribute.set_raises, scope, ")")
        yield f"{text};"
        own = (*scope, attribute.name)
        yield from self._repository_id(own, attribute.repository_id)

    def _call(self, operation: Operation, scope: ScopedName) -> str:
        names = [p.name for p in operation.parameters]
        parameters = (
            f"{p.direction.value} {self._type(p.type, scope, names)} {self._escaped(p.name)}"
            f"{_comment_after(p)}"
            for p in operation.parameters
        )
        text = f"{self._escaped(operation.name)}({', '.join(parameters)})"
        text += self._listed(" raises (", operation.raises, scope, ")")
        if operation.context:
            contexts = ", ".join(map(readable_string, operation.context))
            text += f" context ({contexts})"
        return text

    # Lines above a declaration or member

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
        """Return an argument of an annotation, as a value of its own kind or of the type."""
        plain = None if type_ is None else self._model.unalias(type_)
        if isinstance(value, str):
            if not (
                plain == PrimitiveType(Primitive.WCHAR)
                or (isinstance(plain, StringType) and plain.wide)
            ):
                return readable_string(value)
            return self._literal(StringType(wide=True), value)
        if plain is None or isinstance(plain, SequenceType | ArrayType):
            plain = PrimitiveType(
                Primitive.DOUBLE if isinstance(value, float) else Primitive.LONG
            )
        return self._literal(plain, value)

    def _literal(self, type_: Type, value: ConstantValue) -> str:
        return literal(self._model, type_, value, self._escaped)

    # Types.

    def _declarator(self, type_: Type, name: str, scope: ScopedName) -> str:
        """Return `type name`, with an array's dimensions after the name."""
        if isinstance(type_, ArrayType):
            dimensions = "".join(f"[{size}]" for size in type_.dimensions)
            return f"{self._type(type_.element, scope)} {name}{dimensions}"
        return f"{self._type(type_, scope)} {name}"

    def _type(
        self, type_: Type, scope: ScopedName, beside: Collection[str] = ()
    ) -> str:
        """Return a type; `beside` is the name of the item that has it."""
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
        """Return the name of a type, or at its first use the definition of one declared in
        place.
        """
        holder = self._model.find(scope) if scope in self._names else None
        if (
            isinstance(holder, _INLINE)
            and name[:-1] == scope
            and not self._names.is_written(name)
        ):
            self._names.done.add(name)
            lines = self._definition(self._model.find(name))
            return "\n".join(lines).replace("\n", f"\n{STEP}")
        return self._names.text(name, scope, beside)


def _comment_after(parameter: Parameter) -> str:
    text = " ".join(" ".join(comment_lines(parameter.doc)).split())
    return f" /**< {text} */" if text else ""


def _indented(lines: Iterable[str], depth: int) -> str:
    """Return the lines, indented for their module, and an empty line."""
    text = "\n".join(lines)
    margin = STEP * depth
    indented = (
        line if line.startswith("#") or not line else margin + line
        for line in text.split("\n")
    )
    return "\n".join(indented) + "\n"
