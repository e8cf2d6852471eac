"""Pass over celltypes: reads signatures and types, adds ports, attributes and variables."""

from __future__ import annotations

from collections.abc import Sequence

from rtgen.compiler.diagnostics import Related
from rtgen.compiler.frontends.cdl.names.entities import (
    DECLARE,
    Cell,
    Celltype,
    Composite,
    HiddenFor,
    Member,
    Names,
    Place,
    Port,
    Report,
    Values,
    Variable,
    component,
    here,
)
from rtgen.compiler.frontends.cdl.names.scopes import Entity, Kind
from rtgen.compiler.frontends.cdl.passes import allocators, specifiers
from rtgen.compiler.frontends.cdl.passes.factories import Factories
from rtgen.compiler.frontends.cdl.passes.plugins import Applied
from rtgen.compiler.frontends.cdl.passes.requirements import Requirements
from rtgen.compiler.frontends.cdl.rules import celltypes as rules
from rtgen.compiler.frontends.cdl.rules import syntax
from rtgen.compiler.frontends.cdl.rules.cells import MADE_BY_PLUGIN
from rtgen.compiler.frontends.cdl.syntax import statements, tree
from rtgen.compiler.frontends.kit.suggestions import nearest
from rtgen.compiler.model.c_types import CArrayType, CPointerType, CType, resolve
from rtgen.compiler.model.tecs import Signature
from rtgen.compiler.model.types import ScopedName

_NO_EXPRESSION = (tree.Name, tree.Allocation, tree.Restriction)


class Celltypes:
    """Analyses the bodies of celltypes, and the exported members of composites."""

    def __init__(self, values: Values, applied: Applied, report: Report) -> None:
        self._values = values
        self._applied = applied
        self._report = report
        self._requirements = Requirements(self.add, self._may_be_declared, report)
        self._factories = Factories(values, report)

    def fill(self, type_: Celltype, node: statements.Celltype) -> None:
        """Analyse the body of a celltype."""
        place = type_.place
        for item in node.items:
            part = item.node
            if not isinstance(part, statements.Port):
                words = item.specifiers
                specifiers.accepted(words, (), _named(part), place, self._report)
            match part:
                case statements.Port():
                    self.port(type_, item, part)
                case statements.Attributes():
                    self.variables(type_, part)
                case statements.Require():
                    self._requirements.take(type_, part)
                case statements.Factory():
                    self._factories.take(type_, part)
        self.sizes(type_)
        for port in type_.ports:
            if port.required is None:
                self._hidden(type_, port)
        for port in type_.ports:
            allocators.resolve(type_, port, self._report)
        entries = any(port.kind == "entry" for port in type_.ports)
        if not entries and type_.inactive:
            self._report(
                rules.NO_ENTRY.at(
                    type_.entity.place,
                    f"{type_.name} has no entry port, is not active and has no factory",
                    hint="put [active] before it if its cells run by themselves",
                )
            )

    def add(self, type_: Celltype, member: Member) -> bool:
        """Add a member to a celltype; a second one of that name is reported and dropped."""
        first = type_.members.setdefault(member.name, member)
        if first is member:
            return True
        self._report(
            rules.NAME_TWICE.at(
                member.span,
                f"{member.name} is declared twice in {type_.name}",
                related=[Related(first.span, "first declared here")],
                hint="rename one",
            )
        )
        return False

    # Ports

    def port(
        self, type_: Celltype, item: statements.Item, node: statements.Port
    ) -> Port:
        """Add a port; for a composite, also the call ports for its allocators."""
        place = type_.place
        outer = isinstance(type_, Composite)
        array, size = self._size(node, place)
        port = Port(
            name=node.name.text,
            kind=node.kind,
            signature=self._signature(node.signature, place),
            signature_name=tuple(part.text for part in node.signature.parts),
            span=place.span(node.name),
            array=array,
            size=size,
        )
        words = specifiers.OUTER_PORT if outer else specifiers.PORT
        given = specifiers.accepted(
            item.specifiers, words, f"a port of {type_.name}", place, self._report
        )
        self._flags(port, given, place)
        if node.target is not None:
            self._fixed(port, node.target, place)
        if self.add(type_, port) and outer:
            self._hidden(type_, port)
        return port

    def _signature(self, name: tree.ScopedName, place: Place) -> Signature | None:
        found = place.lookup(name)
        if found is None:
            if not self._may_be_declared(name, place):
                self._report(
                    rules.UNKNOWN_SIGNATURE.at(
                        place.span(name),
                        f"there is no signature {name}",
                        hint=place.near(name.parts[-1], Kind.SIGNATURE) or DECLARE,
                    )
                )
        elif not isinstance(found, Entity) or found.kind is not Kind.SIGNATURE:
            self._report(
                rules.NOT_A_SIGNATURE.at(
                    place.span(name),
                    f"{name} is a {found.kind}, no signature",
                    related=here(found),
                )
            )
        elif isinstance(found.declaration, Signature):
            return found.declaration
        return None

    def _may_be_declared(self, name: tree.ScopedName, place: Place) -> bool:
        """Return whether an import or plug-in may declare an unknown name; warns of the plug-in."""
        if place.may_be_declared(name) or self._values.incomplete:
            return True
        maker = self._applied.of_types
        if maker is not None:
            message = f"{name} is not declared here; {maker} may do it"
            self._report(MADE_BY_PLUGIN.at(place.span(name), message))
        return maker is not None

    def _declared(self, name: ScopedName, place: Place) -> Signature | None:
        """Return the signature of a name, looked up from the root scope."""
        scope = place.scope.root
        for part in name[:-1]:
            scope = scope.scopes[part]
        declaration = scope.entities[name[-1]].declaration
        return declaration if isinstance(declaration, Signature) else None

    def _size(self, node: statements.Port, place: Place) -> tuple[bool, int | None]:
        if node.subscript is None:
            return False, None
        index = node.subscript.index
        if index is None:
            return True, None
        size = self._values.constant(index, place)
        if isinstance(size, int) and not isinstance(size, bool):
            return True, size
        self._report(
            rules.BAD_PORT_SIZE.at(
                place.span(index),
                f"the size of {node.name.text} is not a constant integer",
                hint=f"write a number, or {node.name.text}[] for an array of any size",
            )
        )
        return True, None

    def _flags(self, port: Port, given: list[tree.Specifier], place: Place) -> None:
        for specifier in given:
            word = specifier.word
            side = "entry" if word in ("inline", "allocator") else "call"
            if side != port.kind:
                self._report(
                    rules.PORT_SPECIFIER.at(
                        place.span(specifier),
                        f"{word} is for {side} ports; {port.name} is a {port.kind} port",
                        related=[Related(port.span, "the port")],
                        hint="remove it",
                    )
                )
            elif word != "allocator":
                port.flags.add(word)
        allocator = specifiers.once(given, "allocator", place, self._report)
        if allocator is not None and port.kind == "entry":
            port.allocations = tuple(
                a for a in allocator.arguments if isinstance(a, tree.Allocation)
            )
        late = next(
            (s for s in given if s.word in port.flags & {"dynamic", "ref_desc"}), None
        )
        if late is not None and port.omitted:
            reason = (
                f"{port.name} is omit"
                if "omit" in port.flags
                else f"the signature of {port.name} has no functions"
            )
            message = f"{late.word} has no use: {reason}"
            self._report(rules.SPECIFIERS_CLASH.at(place.span(late), message))

    def _fixed(self, port: Port, target: statements.PortOf, place: Place) -> None:
        problem = self._fixed_problem(port, target, place)
        if problem is None:
            port.fixed, port.fixed_place = target, place
            return
        message, hint, related = problem
        span = place.span(target)
        self._report(rules.BAD_FIXED_JOIN.at(span, message, related=related, hint=hint))

    def _fixed_problem(
        self, port: Port, target: statements.PortOf, place: Place
    ) -> tuple[str, str | None, list[Related]] | None:
        if port.kind == "call":
            message = (
                f"{port.name} is a call port: a fixed join belongs to an entry port"
            )
            return message, None, []
        owner = place.lookup(target.owner)
        type_ = component(owner)
        if isinstance(type_, Cell):
            type_ = type_.celltype
        if owner is None or not isinstance(type_, Celltype):
            if owner is not None and owner.kind in (Kind.CELL, Kind.CELLTYPE):
                return None  # has errors, already reported
            if owner is None and self._may_be_declared(target.owner, place):
                return None
            message = f"{target.owner} is not a celltype"
            return message, "name a singleton celltype that is declared before", []
        if owner.kind is not Kind.CELL and not type_.singleton:
            related = [Related(type_.entity.place, "declared here")]
            return f"{type_.name} is not a singleton", None, related
        caller = type_.members.get(target.port.text)
        if not isinstance(caller, Port) or caller.kind != "call":
            near = nearest(
                target.port.text, (p.name for p in type_.ports if p.kind == "call")
            )
            hint = f"did you mean {near}?" if near else None
            return f"{type_.name} has no call port {target.port.text}", hint, []
        if not caller.array or caller.size is not None:
            message = f"{caller.name} is not a call port array without a size"
            hint = f"declare it as {caller.name}[]"
            return message, hint, [Related(caller.span, "declared here")]
        return None

    def _hidden(self, type_: Celltype, port: Port) -> None:
        """Add the call ports for the allocators of send and receive parameters."""
        own = {
            (a.path[0].text, a.path[1].text)
            for a in port.allocations
            if a.operator == "=" and len(a.path) == 2 and isinstance(type_, Composite)
        }
        for function, parameter, allocator in list(port.parameters()):
            if (function, parameter) in own:
                continue
            signature = self._declared(allocator, type_.place)
            self.add(
                type_,
                Port(
                    name=f"{port.name}_{function}_{parameter}",
                    kind="call",
                    signature=signature,
                    signature_name=allocator,
                    span=port.span,
                    array=port.array,
                    size=port.size,
                    flags=port.flags & {"optional", "omit"},
                    hidden=HiddenFor(port, function, parameter),
                ),
            )

    # Attributes and variables

    def variables(self, type_: Celltype, node: statements.Attributes) -> None:
        """Add the members of a block of attributes or variables."""
        place, kind = type_.place, node.keyword
        words = specifiers.ATTRIBUTE if kind == "attr" else specifiers.VARIABLE
        what = "an attribute" if kind == "attr" else "a variable"
        for item in node.items:
            if not isinstance(item.node, tree.Declaration):
                continue
            given = specifiers.accepted(
                item.specifiers, words, what, place, self._report
            )
            for surplus in given[1:]:
                self._report(
                    syntax.MISPLACED_SPECIFIER.at(
                        place.span(surplus),
                        f"{surplus.word} cannot be combined with {given[0].word}",
                        hint="an attribute has one specifier",
                    )
                )
            for declared in self._values.declare(item.node, place):
                variable = Variable(
                    name=declared.name.text,
                    kind=kind,
                    type=declared.type,
                    value=declared.value,
                    place=place,
                    span=place.span(declared.name),
                )
                self._specify(variable, given[:1])
                if self.add(type_, variable):
                    self._check_value(type_, variable)

    def _specify(self, variable: Variable, given: Sequence[tree.Specifier]) -> None:
        for specifier in given:
            match specifier.word:
                case "omit":
                    variable.omit = True
                case "choice":
                    variable.choice = tuple(
                        a.text for a in specifier.arguments if isinstance(a, tree.Text)
                    )
                case "size_is":
                    size_is = specifier.arguments[0]
                    assert not isinstance(size_is, _NO_EXPRESSION)
                    variable.size_is = size_is
        type_ = variable.type
        if type_ is None:
            return
        real = resolve(type_)
        if isinstance(real, CArrayType) and real.size is None and not variable.omit:
            self._report(
                rules.OPEN_ARRAY.at(
                    variable.span,
                    f"the array {variable.name} has no size",
                    hint="write it between the brackets"
                    + (", or put [omit] before it" if variable.kind == "attr" else ""),
                )
            )
        if variable.size_is is not None and not isinstance(real, CPointerType):
            self._report(
                rules.SIZE_IS_OF_NO_POINTER.at(
                    variable.span,
                    f"{variable.name} has size_is and is not a pointer",
                    hint=f"declare *{variable.name}",
                )
            )
            variable.size_is = None

    def _check_value(self, type_: Celltype, variable: Variable) -> None:
        if variable.value is None or variable.type is None:
            return
        types = {} if variable.kind == "attr" else attribute_types(type_)
        if not self._sized_list(variable):
            variable.initial = self._values.initial(
                variable.type, variable.value, type_.place, types
            )

    def _sized_list(self, variable: Variable) -> bool:
        """Return whether a list initialises a pointer without a size, which is reported."""
        assert variable.type is not None
        if not is_unsized_list(variable, variable.value):
            return False
        assert variable.value is not None
        self._report(
            rules.UNSIZED_INITIALISER.at(
                variable.place.span(variable.value),
                f"{variable.name} is a pointer without size_is and cannot have a list",
                hint="put [size_is( n )] before it",
            )
        )
        return True

    def sizes(self, type_: Celltype) -> None:
        """Resolve sizes, and check lists whose sizes are known in the celltype.

        In a composite, the inner cells are checked.
        """
        for variable in type_.variables:
            value, size_is = variable.value, variable.size_is
            if size_is is None:
                continue
            variable.size = self._values.expression(
                size_is, variable.place, attribute_types(type_)
            )
            if variable.size is None:
                variable.size_is = None
            if value is None or variable.size is None or isinstance(type_, Composite):
                continue
            if not isinstance(value, tree.Aggregate):
                self._report(
                    rules.SIZED_INITIALISER.at(
                        variable.place.span(value),
                        f"{variable.name} has size_is and requires a list",
                        hint="write { ... }",
                    )
                )
                continue
            size = declared_size(self._values, type_, variable)
            check_length(variable, value, size, variable.place, self._report)


def attribute_values(type_: Celltype, cell: Cell | None = None) -> Names:
    """Return the values of attributes by name: the cell's, else the default of the celltype."""

    def value(name: str) -> tuple[tree.Initialiser, Place] | None:
        if cell is not None and name in cell.joins:
            join = cell.joins[name][0]
            if join.value is not None and not isinstance(join.value, tree.OfComposite):
                return join.value, join.place
        found = type_.members.get(name)
        if (
            isinstance(found, Variable)
            and found.kind == "attr"
            and found.value is not None
        ):
            return found.value, found.place
        return None

    return value


def declared_size(values: Values, type_: Celltype, variable: Variable) -> object:
    """Return a list's size by the celltype's defaults; an attribute without one counts as 0."""
    given = attribute_values(type_)

    def names(name: str) -> tuple[tree.Initialiser, Place] | None:
        found = type_.members.get(name)
        if isinstance(found, Variable) and found.kind == "attr" and found.value is None:
            return tree.Number(0, 0, "0"), found.place
        return given(name)

    assert variable.size_is is not None
    return values.constant(variable.size_is, variable.place, names)


def attribute_types(type_: Celltype) -> dict[str, CType]:
    """Return the types of the attributes."""
    return {
        v.name: v.type
        for v in type_.variables
        if v.kind == "attr" and v.type is not None
    }


def is_unsized_list(variable: Variable, value: object) -> bool:
    """Return whether a value is a list for a pointer without size."""
    return (
        variable.type is not None
        and variable.size_is is None
        and isinstance(value, tree.Aggregate)
        and isinstance(resolve(variable.type), CPointerType)
    )


def check_length(
    variable: Variable,
    value: tree.Aggregate,
    size: object,
    place: Place,
    report: Report,
) -> None:
    """Report a list that is longer than its size, if the size is known."""
    if isinstance(size, int) and size < len(value.items):
        report(
            rules.SIZED_INITIALISER.at(
                place.span(value),
                f"{len(value.items)} values for {variable.name}, which holds {size}",
                related=[Related(variable.span, "declared here")],
                hint=(
                    None if size else "give the size a value, or the list in the cells"
                ),
            )
        )


def _named(part: object) -> str:
    if isinstance(part, statements.Attributes):
        return f"{part.keyword} {{ }}"
    return "require" if isinstance(part, statements.Require) else "a factory"
