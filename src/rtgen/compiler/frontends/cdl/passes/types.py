"""Pass over types: reads names declared before, adds typedefs, structs and enums to the table."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from msgspec.structs import replace

from rtgen.compiler.diagnostics import Related
from rtgen.compiler.frontends.cdl.names.c_types import (
    MAX_DEPTH,
    OPAQUE,
    depth,
    is_void,
    opaque,
)
from rtgen.compiler.frontends.cdl.names.entities import Place
from rtgen.compiler.frontends.cdl.names.scopes import Entity, Kind, Scope
from rtgen.compiler.frontends.cdl.names.table import Table
from rtgen.compiler.frontends.cdl.passes import prelude
from rtgen.compiler.frontends.cdl.passes.expressions import Expressions
from rtgen.compiler.frontends.cdl.passes.specifiers import belongs
from rtgen.compiler.frontends.cdl.passes.untagged import UNTAGGED, name_of_untagged
from rtgen.compiler.frontends.cdl.rules import signatures as signature_rules
from rtgen.compiler.frontends.cdl.rules import syntax
from rtgen.compiler.frontends.cdl.rules import types as rules
from rtgen.compiler.frontends.cdl.syntax import tree
from rtgen.compiler.model.c_types import (
    CArrayType,
    CEnumType,
    CFunctionType,
    CPointerType,
    CScalarType,
    CStructType,
    CType,
    CTypedefType,
    DescriptorType,
    resolve,
)
from rtgen.compiler.model.tecs import (
    Sizes,
    TecsEnum,
    TecsMember,
    TecsStruct,
    TecsTypedef,
)
from rtgen.compiler.model.types import ScopedName
from rtgen.facts.tdr import Scalar

_SCALARS = {kind: CScalarType(kind) for kind in Scalar}
_CHAR = CScalarType(Scalar.CHAR, plain=True)
_SIGNED = {
    Scalar.CHAR: (Scalar.SCHAR, Scalar.UCHAR),
    Scalar.SHORT: (Scalar.SHORT, Scalar.USHORT),
    Scalar.INT: (Scalar.INT, Scalar.UINT),
    Scalar.LONG: (Scalar.LONG, Scalar.ULONG),
    Scalar.INT8: (Scalar.INT8, Scalar.UINT8),
    Scalar.INT16: (Scalar.INT16, Scalar.UINT16),
    Scalar.INT32: (Scalar.INT32, Scalar.UINT32),
    Scalar.INT64: (Scalar.INT64, Scalar.UINT64),
    Scalar.INT128: (Scalar.INT128, Scalar.UINT128),
}
_WITH_SIZE = frozenset(
    (Scalar.INT8, Scalar.INT16, Scalar.INT32, Scalar.INT64, Scalar.INT128)
)


def _same(one: tuple[TecsMember, ...], other: tuple[TecsMember, ...]) -> bool:
    return [(m.name, str(m.type)) for m in one] == [
        (m.name, str(m.type)) for m in other
    ]


def _entity(
    kind: Kind,
    node: tree.StructSpecifier | tree.EnumSpecifier,
    place: Place,
    name: str,
) -> Entity:
    """Return the entity of a struct or enum, with an unused name: its tag, else `name`."""
    keyword = "struct" if isinstance(node, tree.StructSpecifier) else node.keyword
    span = place.unit.span(node.start, node.start + len(keyword))
    if node.tag is not None:
        name, span = node.tag.text, place.span(node.tag)
    while name in place.scope.structs:
        name += "_"
    return Entity(kind, (*place.scope.name, name), place.unit, node, span)


def _referred(tag: tree.Name, scope: Scope) -> ScopedName:
    """Return the name of the struct or enum with a tag, which may be declared later."""
    entity = scope.find_tag(tag.text)
    return entity.name if entity else (*scope.name, tag.text)


class Types:
    """Lowers types from the syntax tree, and declares the structs and enums defined in them."""

    def __init__(self, table: Table) -> None:
        self._table = table
        self._report = table.report
        self.expressions = Expressions(table, self.of_name)
        self._unresolved_descriptors: list[tuple[tree.ScopedName, Place]] = []

    def of(
        self, node: tree.QualifiedType, place: Place, name: str = UNTAGGED
    ) -> CType | None:
        """Return the type with its qualifiers; None, after a diagnostic, if it has errors.

        `name` is that of a struct or enum without a tag (`name_of_untagged`).
        """
        found = self._specified(node.type, place, name)
        if found is None or isinstance(
            found, CArrayType | CFunctionType | DescriptorType
        ):
            return found
        words = {word.text for word in node.qualifiers}
        if not words:
            return found
        return replace(
            found,
            const=found.const or "const" in words,
            volatile=found.volatile or "volatile" in words,
        )

    def of_name(self, node: tree.TypeName, place: Place) -> CType | None:
        """Return the type of a cast; None, after a diagnostic, if it has errors."""
        base = self.of(node.type, place)
        return self.declared(base, node.declarator, place)

    def _specified(
        self, node: tree.TypeSpecifier, place: Place, name: str
    ) -> CType | None:
        if isinstance(node, tree.BasicType):
            return self._basic(node, place)
        if isinstance(node, tree.TypedefName):
            return self._typedef(node, place)
        if isinstance(node, tree.StructSpecifier):
            return self._struct(node, place, name)
        if isinstance(node, tree.EnumSpecifier):
            return self._enum(node, place, name)
        return self._descriptor(node.signature, place)

    def _descriptor(self, node: tree.ScopedName, place: Place) -> CType | None:
        """Return the type of a descriptor, whose signature may be declared later."""
        if place.scope.find(node) is None:
            self._unresolved_descriptors.append((node, place))
            around = () if node.absolute or len(node.parts) > 1 else place.scope.name
            return DescriptorType((*around, *(part.text for part in node.parts)))
        return self._signature(node, place)

    def _signature(self, node: tree.ScopedName, place: Place) -> CType | None:
        entity = self._table.find(node, place, (Kind.SIGNATURE,), "a descriptor")
        return None if entity is None else DescriptorType(entity.name)

    def finish(self) -> None:
        """Resolve signatures of descriptors that are declared after their use."""
        for node, place in self._unresolved_descriptors:
            self._signature(node, place)

    def _basic(self, node: tree.BasicType, place: Place) -> CType | None:
        if node.sign is None:
            return _CHAR if node.plain else _SCALARS[node.kind]
        span = place.span(node)
        if node.kind not in _SIGNED:
            message = f"{node.kind} has a sign of its own"
            self._report(rules.SIGN_TWICE.at(span, message))
            return None
        signed, unsigned = _SIGNED[node.kind]
        kind = signed if node.sign == "signed" else unsigned
        if node.kind in _WITH_SIZE:
            message = f"'{node.sign} {node.kind}' is an old way to write {kind}"
            self._report(rules.SIGN_OF_SIZED.at(span, message, hint=f"write {kind}"))
        return CScalarType(kind, plain=node.plain)

    def _typedef(self, node: tree.TypedefName, place: Place) -> CType | None:
        name = node.name.text
        for around in place.scope.outwards():
            entity = around.entities.get(name)
            if entity is not None and entity.kind is Kind.TYPEDEF:
                if isinstance(entity.declaration, TecsTypedef):
                    return CTypedefType(entity.name, entity.declaration.type)
                return None
        if name in prelude.TYPES and self._table.with_prelude:
            self._table.note_prelude(name, place, node.name)
            return CTypedefType((name,), prelude.TYPES[name])
        if name in place.unit.guessed:
            return CTypedefType((name,), opaque(name))
        return None  # reported by the parser

    def _struct(
        self, node: tree.StructSpecifier, place: Place, name: str
    ) -> CType | None:
        if node.members is None:
            assert node.tag is not None
            return CStructType(_referred(node.tag, place.scope))
        known = place.scope.tags.get(node.tag.text) if node.tag else None
        if known is not None and isinstance(known.declaration, TecsStruct):
            members = self._members(node.members, place, known.name[-1])
            if members is not None and _same(members, known.declaration.members):
                return CStructType(known.name)
        entity = _entity(Kind.STRUCT, node, place, name)
        if not self._declare_tag(place.scope, node.tag, entity):
            return None
        members = self._members(node.members, place, entity.name[-1])
        if members is None:
            entity.broken = True
            return None
        entity.declaration = TecsStruct(
            name=entity.name,
            file=place.unit.source.name,
            span=entity.place,
            doc=place.doc(node),
            members=members,
        )
        self._table.declared(entity)
        return CStructType(entity.name)

    def _declare_tag(self, scope: Scope, tag: tree.Name | None, entity: Entity) -> bool:
        known = scope.tags.setdefault(tag.text, entity) if tag else entity
        if known is entity:
            scope.structs[entity.name[-1]] = entity
            return True
        self._report(
            rules.DECLARED_TWICE.at(
                entity.place,
                f"the {entity.kind} '{known.name[-1]}' is declared already",
                related=[Related(known.place, "first declared here")],
            )
        )
        return False

    def _members(
        self, items: Iterable[tree.MemberItem], place: Place, tag: str
    ) -> tuple[TecsMember, ...] | None:
        found: dict[str, tuple[tree.MemberItem, tree.Name, CType]] = {}
        ok = True
        for item in items:
            name_of_type = f"{tag}_{name_of_untagged(item.declarators)}"
            base = self.of(item.type, place, name_of_type)
            for declarator in item.declarators:
                type_ = self.declared(base, declarator, place)
                name = declarator.name
                if type_ is None or name is None:
                    ok = False
                elif name.text in found:
                    self._report(
                        rules.MEMBER_TWICE.at(
                            place.span(name),
                            f"the member '{name.text}' is declared already",
                            related=[
                                Related(
                                    place.span(found[name.text][1]),
                                    "first declared here",
                                )
                            ],
                        )
                    )
                    ok = False
                else:
                    ok &= self.is_value(type_, place, name, member=True)
                    found[name.text] = (item, name, type_)
        types = {name: type_ for name, (_, _, type_) in found.items()}
        members = []
        for item, name, type_ in found.values():
            sizes = self._member_sizes(item.specifiers, name, type_, types, place)
            if sizes is None:
                ok = False
            else:
                members.append(
                    TecsMember(
                        name=name.text,
                        type=type_,
                        sizes=sizes,
                        span=place.span(name),
                        doc=place.doc(item),
                    )
                )
        return tuple(members) if ok else None

    def _member_sizes(
        self,
        bracket: tree.Specifiers | None,
        name: tree.Name,
        type_: CType,
        members: Mapping[str, CType],
        place: Place,
    ) -> Sizes | None:
        if bracket is None:
            return Sizes()
        given: dict[str, tree.Specifier] = {}
        for specifier in bracket.items:
            span = place.span(specifier)
            if specifier.word not in ("size_is", "count_is", "string"):
                message = f"'{specifier.word}' cannot precede a struct member"
                hint = belongs(specifier.word)
                self._report(syntax.MISPLACED_SPECIFIER.at(span, message, hint=hint))
                return None
            if specifier.word in given:
                message = f"'{specifier.word}' is given already"
                self._report(signature_rules.SPECIFIER_TWICE.at(span, message))
                return None
            if len(specifier.arguments) > 1:
                message = "a struct member has no limit of size_is"
                self._report(syntax.MISPLACED_SPECIFIER.at(span, message))
                return None
            given[specifier.word] = specifier
        if not isinstance(resolve(type_), CPointerType):
            self._report(
                rules.MEMBER_SIZE.at(
                    place.span(name),
                    f"'{name.text}' is not a pointer, so {' and '.join(given)} cannot apply",
                )
            )
            return None
        expressions = self.expressions
        values = {
            word: expressions.size(specifier.arguments[0], place, members)
            for word, specifier in given.items()
            if specifier.arguments
        }
        if None in values.values():
            return None
        return Sizes(
            size_is=values.get("size_is"),
            count_is=values.get("count_is"),
            string=values.get("string"),
            unsized_string="string" in given and not given["string"].arguments,
        )

    def _enum(self, node: tree.EnumSpecifier, place: Place, name: str) -> CType | None:
        bits = int(node.keyword.removeprefix("enum") or 0) or None
        if node.enumerators is None:
            assert node.tag is not None
            return CEnumType(_referred(node.tag, place.scope), bits)
        members: list[tuple[str, int]] = []
        value = -1
        for enumerator in node.enumerators:
            if enumerator.value is not None:
                given = self.expressions.integer(enumerator.value, place)
                if given is None:
                    return None
                value = given
            else:
                value += 1
            members.append((enumerator.name.text, value))
        entity = _entity(Kind.ENUM, node, place, name)
        if not self._declare_tag(place.scope, node.tag, entity):
            return None
        entity.declaration = TecsEnum(
            name=entity.name,
            file=place.unit.source.name,
            span=entity.place,
            doc=place.doc(node),
            members=tuple(members),
            bits=bits,
        )
        self._table.declared(entity)
        return CEnumType(entity.name, bits)

    def declared(
        self, base: CType | None, declarator: tree.Declarator | None, place: Place
    ) -> CType | None:
        """Return the type of a declarator, given its base type; None if it has errors."""
        if base is None or declarator is None:
            return base
        type_ = base
        for pointer in declarator.pointers:
            word = pointer.qualifier.text if pointer.qualifier else ""
            type_ = CPointerType(type_, word == "const", word == "volatile")
        for suffix in reversed(declarator.suffixes):
            if isinstance(suffix, tree.Parameters):
                made = self._function(type_, suffix, place)
            else:
                made = self._array(type_, suffix, place)
            if made is None:
                return None
            type_ = made
        inner = declarator.inner
        if isinstance(inner, tree.Declarator):
            return self.declared(type_, inner, place)
        if depth(type_) > MAX_DEPTH:
            span = place.span(declarator)
            message = f"types are nested for more than {MAX_DEPTH} levels"
            self._report(syntax.TOO_DEEP.at(span, message))
            return None
        return type_

    def _array(
        self, element: CType, suffix: tree.ArraySuffix, place: Place
    ) -> CType | None:
        if isinstance(element, CArrayType) and element.size is None:
            span = place.span(suffix)
            message = "only the first dimension of an array may be left out"
            self._report(rules.ARRAY_SIZE.at(span, message))
            return None
        if suffix.size is None:
            return CArrayType(element, None)
        size = self.expressions.integer(suffix.size, place)
        if size is None:
            return None
        if size <= 0:
            message = f"the size of an array is positive, not {size}"
            self._report(rules.ARRAY_SIZE.at(place.span(suffix.size), message))
            return None
        return CArrayType(element, size)

    def _function(
        self, returns: CType, node: tree.Parameters, place: Place
    ) -> CType | None:
        parameters = []
        for item in node.items:
            base = self.of(item.type, place)
            type_ = self.declared(base, item.declarator, place)
            if type_ is None:
                return None
            if not (is_void(type_) and item.declarator is None):
                parameters.append(type_)
        return CFunctionType(returns, tuple(parameters))

    def is_value(
        self, type_: CType, place: Place, name: tree.Name, *, member: bool = False
    ) -> bool:
        """Return whether a value can have the type; reports the error if not."""
        inner = type_
        while isinstance(inner, CArrayType):
            inner = resolve(inner.element)
        if is_void(inner):
            message = f"'{name.text}' cannot be of type void"
            self._report(rules.VOID_VALUE.at(place.span(name), message))
            return False
        found = resolve(inner)
        if isinstance(found, CStructType) and not found.tag[0].startswith(OPAQUE):
            entity = self._table.tag(found.tag)
            if entity is None:
                if not self._table.incomplete:
                    message = f"the members of {found} are not known"
                    hint = "declare it before"
                    span = place.span(name)
                    self._report(rules.UNKNOWN_STRUCT.at(span, message, hint=hint))
                return False
            if entity.declaration is None and not entity.broken:
                message = f"{found} cannot hold itself"
                hint = "use a pointer"
                span = place.span(name)
                self._report(rules.UNKNOWN_STRUCT.at(span, message, hint=hint))
                return False
        return member or self.knows_struct(inner, place, name)

    def knows_struct(self, type_: CType, place: Place, name: tree.Name) -> bool:
        """Return whether the struct of a type, or of its target, is complete; reports it if not."""
        target = type_
        while isinstance(target, CPointerType | CArrayType):
            target = (
                target.target if isinstance(target, CPointerType) else target.element
            )
        if (
            not isinstance(target, CStructType)
            or target.tag[0].startswith(OPAQUE)
            or self._table.tag(target.tag) is not None
        ):
            return True
        if not self._table.incomplete:
            message = f"{target} is not known here"
            hint = "declare it before; only a struct member may point to a later one"
            span = place.span(name)
            self._report(rules.UNKNOWN_STRUCT.at(span, message, hint=hint))
        return False
