"""The statements that marshal a value, and those that copy one, printed from its layout."""

from __future__ import annotations

from rtgen.backends.types.constants import Layouts
from rtgen.backends.types.locals import Body, Locals
from rtgen.backends.types.scope import Scope
from rtgen.backends.types.values import Tables, each
from rtgen.layouts.cdr import (
    Atom,
    AtomArray,
    AtomSequence,
    Call,
    Dynamic,
    Field,
    Group,
    Jump,
    Loop,
    Node,
    Path,
    Records,
    Reference,
    Repeat,
    Run,
    Step,
    Text,
    TextArray,
    TextSequence,
)


class Encoder:
    """Writes the body of `to_cdr` or `_write_`.

    `layouts` names the layout of each run and of the elements of each `Records`, in wire order.
    """

    def __init__(self, scope: Scope, tables: Tables, layouts: Layouts) -> None:
        self._py = scope
        self._tables = tables
        self._layouts = layouts
        self._locals = Locals(scope.globals, "value")
        self._bound: dict[Path, str] = {}
        self.body = Body()

    def whole(self, run: Run, base: str) -> list[str]:
        """The body of a value that one `struct` call packs."""
        self._bound = {(): base}
        arguments, counts = self._arguments(run, ())
        layout = self._layouts.of(run)
        self.body.choose("pack", "pack", layout)
        shape = f"[{', '.join(counts)}]" if counts else ""
        return [*self.body.lines, f"return pack{shape}({', '.join(arguments)})"]

    def parts(self, steps: tuple[Step, ...], base: str) -> list[str]:
        """The body of a value whose parts are appended to `out`."""
        self._bound = {(): base}
        self.steps(steps, ())
        return self.body.lines

    def steps(self, steps: tuple[Step, ...], prefix: Path) -> None:
        """The steps of a value that stands at `prefix`."""
        for step in steps:
            match step:
                case Run():
                    self._run(step, prefix)
                case Loop(path=path, node=node):
                    self._loop(step, (*prefix, *path), node)
                case Jump(path=path, node=Call()):
                    self.body.add(
                        f"{self._value((*prefix, *path))}._write_(out, little_endian)"
                    )
                case Jump(path=path, node=Dynamic() as dynamic):
                    value = self._value((*prefix, *path))
                    described = self._tables.dynamic(dynamic)
                    arguments = f"out, {value}, {described}, little_endian"
                    self.body.add(f"{self._py.write_dynamic}({arguments})")
                case Jump(path=path):
                    value = self._value((*prefix, *path))
                    self.body.add(
                        f"{self._py.write_reference}(out, {value}, little_endian)"
                    )

    def bind(self, path: Path, expression: str) -> None:
        """The expression stands for the value at the path."""
        self._bound[path] = expression

    def _run(self, run: Run, prefix: Path) -> None:
        arguments, counts = self._arguments(run, prefix)
        pack = self._layouts.variable("pack", run)
        self.body.choose(pack, "pack", self._layouts.of(run))
        shape = counts if run.known else ["len(out) & 7", *counts]
        key = f"[{', '.join(shape)}]" if shape else ""
        self.body.add(f"out += {pack}{key}({', '.join(arguments)})")

    def _loop(self, loop: Loop, path: Path, node: Repeat) -> None:
        items = self._value(path)
        item = self._locals.name(path, "item_")
        inner = (*path, "[]")
        if node.key is not None:
            key = self._locals.name(path, "key_")
            self.body.block(f"for {key}, {item} in {items}.items():")
            self._bound[(*path, "{}")] = key
            self.steps(loop.key_steps, (*path, "{}"))
        else:
            if node.length is not None:
                items = f"{self._py.exact}({items}, {node.length})"
            if not loop.steps:  # an array of empty structs
                self.body.add(items)
                return
            self.body.block(f"for {item} in {items}:")
        self._bound[inner] = item
        self.steps(loop.steps, inner)
        self.body.end()

    def _arguments(self, run: Run, prefix: Path) -> tuple[list[str], list[str]]:
        """What `struct` packs for a run, and the counts among it."""
        arguments: list[str] = []
        counts: list[str] = []
        for field in run.fields:
            path = (*prefix, *field.path)
            count, value = self._field(field.node, path)
            if count is not None:
                arguments.append(count)
            if value is not None:
                arguments.append(value)
            if count is not None and value is not None:
                counts.append(count)
        return arguments, counts

    def _field(self, node: Node, path: Path) -> tuple[str | None, str | None]:
        """The expressions for the count of a field and for its value."""
        tables = self._tables
        match node:
            case Atom():
                return None, tables.packed(node, self._value(path))
            case AtomArray(atom=atom, dimensions=(length,)):
                items = self._items(path)
                self._require(f"len({items}) != {length}")
                return None, f"*{each(tables.packed, atom, items) or items}"
            case AtomArray(atom=atom, dimensions=dimensions):
                items = f"{self._py.flat}({self._value(path)}, {dimensions})"
                return None, f"*{each(tables.packed, atom, items) or items}"
            case TextArray(text=text, length=length):
                octets = tables.packed_text(text, self._value(path))
                return None, f"{self._py.exact}({octets}, {length})"
            case AtomSequence(atom=atom, bound=bound):
                items = self._items(path)
                count = self._count(path, f"len({items})", bound)
                return count, f"*{each(tables.packed, atom, items) or items}"
            case TextSequence():
                return self._text(node, path)
            case Records(length=None, bound=bound):
                items = self._items(path)
                return self._count(path, f"len({items})", bound), self._records(
                    node, path, items
                )
            case Records(length=length):
                items = f"{self._py.exact}({self._value(path)}, {length})"
                return None, self._records(node, path, items)
            case Repeat(bound=bound):
                items = self._items(path)
                return self._count(path, f"len({items})", bound), None
        raise TypeError(node)

    def _text(self, node: TextSequence, path: Path) -> tuple[str, str]:
        octets = self._tables.packed_text(node.text, self._value(path))
        if not octets.isidentifier():
            variable = self._locals.name(path)
            self.body.add(f"{variable} = {octets}")
            octets = variable
        nul = " + 1" if node.text is Text.STRING else ""
        return self._count(path, f"len({octets}){nul}", node.most), octets

    def _records(self, node: Records, path: Path, items: str) -> str:
        pack = self._layouts.variable("pack", node)
        self.body.choose(pack, "pack", self._layouts.of(node))
        arguments = [self._record_value(f) for f in node.fields]
        octets = self._locals.name(path, "octets_")
        packed = f"{pack}({', '.join(arguments)})"
        self.body.add(f'{octets} = b"".join([{packed} for item in {items}])')
        return octets

    def _record_value(self, field: Field) -> str:
        value = ".".join(("item", *field.path))
        node = field.node
        tables = self._tables
        match node:
            case Atom():
                return tables.packed(node, value)
            case AtomArray(atom=atom, dimensions=(length,)):
                exact = f"{self._py.exact}({value}, {length})"
                converted = tables.packed(atom, "x")
                return (
                    f"*{exact}"
                    if converted == "x"
                    else f"*[{converted} for x in {exact}]"
                )
            case AtomArray(atom=atom, dimensions=dimensions):
                flat = f"{self._py.flat}({value}, {dimensions})"
                converted = tables.packed(atom, "x")
                return (
                    f"*{flat}"
                    if converted == "x"
                    else f"*[{converted} for x in {flat}]"
                )
            case TextArray(text=text, length=length):
                return f"{self._py.exact}({tables.packed_text(text, value)}, {length})"
        raise TypeError(node)

    def _count(self, path: Path, expression: str, bound: int | None) -> str:
        count = self._locals.name(path, "n_")
        self.body.add(f"{count} = {expression}")
        if bound is not None:
            self._require(f"{count} > {bound}")
        return count

    def _require(self, failure: str) -> None:
        self.body.block(f"if {failure}:")
        self.body.add('raise ValueError("wrong length")')
        self.body.end()

    def _items(self, path: Path) -> str:
        """A variable for a collection, which is looked at more than once."""
        value = self._value(path)
        if "." not in value:
            return value
        name = self._locals.name(path)
        self.body.add(f"{name} = {value}")
        self._bound[path] = name
        return name

    def _value(self, path: Path) -> str:
        """The expression for a value; structs on the way get variables."""
        if path in self._bound:
            return self._bound[path]
        parent = self._value(path[:-1])
        if "." in parent:
            name = self._locals.name(path[:-1])
            self.body.add(f"{name} = {parent}")
            self._bound[path[:-1]] = parent = name
        return f"{parent}.{path[-1]}"


class Copier:
    """Writes the body of `_snapshot_`."""

    def __init__(self, scope: Scope) -> None:
        self._py = scope
        self._locals = Locals(scope.globals)
        self.body = Body()

    def copy(self, node: Node, value: str, path: Path = ()) -> str:
        """An expression for a copy that shares nothing that can change."""
        match node:
            case AtomSequence():
                return f"list({value})"
            case AtomArray(dimensions=dimensions):
                return _copy_nested(value, len(dimensions))
            case Repeat(key=key) if key is not None:
                inner = self._inner(node.element)
                return f"{{key: {inner} for key, item in {value}.items()}}"
            case Records(element=element) | Repeat(element=element):
                inner = self._inner(element)
                return (
                    f"list({value})"
                    if inner == "item"
                    else f"[{inner} for item in {value}]"
                )
            case Group(name=name, members=members):
                if path:
                    variable = self._locals.name(path)
                    self.body.add(f"{variable} = {value}")
                    value = variable
                copies = [self.copy(n, f"{value}.{m}", (*path, m)) for m, n in members]
                return f"{self._py.reference(name)}({', '.join(copies)})"
            case Call():
                return f"{value}._snapshot_()"
            case Reference():
                return value
        return value

    def _inner(self, node: Node) -> str:
        """The copy of `item`, within a comprehension."""
        return _Inline(self._py).copy(node, "item")


class _Inline(Copier):
    """Copies without variables."""

    def copy(self, node: Node, value: str, path: Path = ()) -> str:
        if isinstance(node, Group):
            copies = [
                self.copy(inner, f"{value}.{name}") for name, inner in node.members
            ]
            return f"{self._py.reference(node.name)}({', '.join(copies)})"
        return super().copy(node, value)


def _copy_nested(value: str, depth: int) -> str:
    if depth == 1:
        return f"list({value})"
    return f"[{_copy_nested('row', depth - 1)} for row in {value}]"
