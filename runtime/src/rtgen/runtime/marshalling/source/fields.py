"""Generates the expressions for the fields of a run, and for the parts that are joined to one."""

from __future__ import annotations

from rtgen.runtime.marshalling.layouts.joined import (
    NULS,
    PADDINGS,
    Heads,
)
from rtgen.runtime.marshalling.layouts.layout import (
    Run,
)
from rtgen.runtime.marshalling.layouts.nodes import (
    Atom,
    AtomArray,
    AtomSequence,
    Field,
    Form,
    Header,
    Node,
    Path,
    Records,
    Repeat,
    Text,
    TextArray,
    TextSequence,
)
from rtgen.runtime.marshalling.layouts.shapes import Fixed, Layouts
from rtgen.runtime.marshalling.octets import (
    exact,
    exact_octets,
    flat,
    octets_in,
)
from rtgen.runtime.marshalling.source.bulk import (
    Arrays,
    Sequences,
    Structured,
    buffer_code,
    flattener,
    lister,
)
from rtgen.runtime.marshalling.source.conversions import Conversions, each
from rtgen.runtime.marshalling.source.references import References
from rtgen.runtime.marshalling.source.text import Body, Locals


class Fields:
    """A function under construction that packs the fields of values."""

    def __init__(self, references: References) -> None:
        self._refer = references
        self.convert = Conversions(references.namespace)
        self._layouts = Layouts()
        self._locals = Locals(references.namespace)
        self._bound: dict[Path, str] = {}
        self._keys: dict[Path, str] = {}
        self.body = Body(references.namespace)

    def _joined(
        self, run: Run, prefix: Path, formats: list[str], padded: bool
    ) -> tuple[list[str], list[str], list[str]]:
        """Return the parts of a run with texts, and the arguments and counts of its packer.

        `padded`: also after a text at its end.
        """
        body = self.body
        heads = self._locals.name((), "heads_")
        body.choose(heads, "heads", Heads, "heads")
        parts: list[str] = []
        values: list[str] = []
        arguments: list[str] = []
        counts: list[str] = []
        following = iter(formats)

        def between() -> None:
            format_ = next(following)
            if format_:
                pack = self._locals.name((*prefix, str(len(parts))), "pack_")
                body.choose(pack, pack, Fixed(format_), "pack")
                parts.append(f"{pack}({', '.join(values)})")
            values.clear()

        for field in run.fields:
            count, value = self._field(field.node, (*prefix, *field.path))
            assert value is not None
            if count is None:
                values.append(value)
                arguments.append(value)
                continue
            between()
            arguments += (count, value)
            counts.append(count)
            parts += (f"{heads}[{count}]", value)
            is_string = getattr(field.node, "text", None) is Text.STRING
            tails = self._refer.namespace.bind(
                "nuls" if is_string else "paddings", NULS if is_string else PADDINGS
            )
            if padded or field is not run.fields[-1]:
                parts.append(f"{tails}[{count} & 3]")
            elif is_string:
                parts.append('b"\\0"')
        between()
        return parts, arguments, counts

    def _arguments(self, run: Run, prefix: Path) -> tuple[list[str], list[str]]:
        """Return the arguments of `pack` for a run, and the key of its shape: the counts."""
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
                counts.append(self._keys.get(path, count))
        return arguments, counts

    def _field(self, node: Node, path: Path) -> tuple[str | None, str | None]:
        """Return the expressions for a field's count and value."""
        convert = self.convert
        match node:
            case Atom():
                return None, convert.packed(node, self._value(path))
            case Header(number):
                return None, str(number)
            case AtomArray() if node.form != "list":
                return None, f"{self._octets(node, path)}({self._value(path)})"
            case AtomArray(atom=atom, dimensions=(length,)):
                items = self._listed(atom, path)
                self._require(f"len({items}) != {length}")
                return None, f"*{each(convert.packed, atom, items) or items}"
            case AtomArray():
                return None, self._flat(node, self._value(path))
            case TextArray(text=Text.OCTETS, length=length):
                octets = self._octets_in(path)
                self._require(f"len({octets}) != {length}")
                return None, octets
            case TextArray():
                return None, self._exact_text(node, self._value(path))
            case AtomSequence(atom=atom, bound=bound) if atom.form is Form.NUMBER:
                items = self._items(path)
                key = self._keys[path] = self._locals.name(path, "key_")
                count = self._count(path, f"len({items})", bound)
                return count, self._bulk(node, path, items, key)
            case AtomSequence(atom=Atom(form=Form.WORD), bound=bound):
                words = self._locals.name(path, "words_")
                self.body.add(f"{words} = {convert.words(self._value(path))}")
                return self._count(path, f"len({words})", bound), f"*{words}"
            case AtomSequence(atom=atom, bound=bound):
                items = self._listed(atom, path)
                count = self._count(path, f"len({items})", bound)
                return count, f"*{each(convert.packed, atom, items) or items}"
            case TextSequence():
                return self._text(node, path)
            case Records(length=None, bound=bound):
                items = self._items(path)
                return self._count(path, f"len({items})", bound), self._records(
                    node, path, items
                )
            case Records(length=length):
                items = f"{self._refer.function(exact)}({self._value(path)}, {length})"
                return None, self._records(node, path, items)
            case Repeat(bound=bound):
                items = self._items(path)
                return self._count(path, f"len({items})", bound), None
        raise TypeError(node)

    def _bulk(self, node: AtomSequence, path: Path, items: str, key: str) -> str:
        """Return the items of a list, or their octets; the key of the shape is in `_keys`."""
        put = self._locals.name(path, "put_")
        self.body.choose(put, put, Sequences(node), "put")
        packed = items
        if not path:  # the value itself, for the error report
            packed = self._locals.name(path, "packed_")
            self.body.add(f"{packed} = {items}")
        self.body.block(f"if {packed}.__class__ is not list:")
        self.body.add(f"{key}, {packed} = {put}({packed})")
        self.body.end()
        return f"*{packed}"

    def _listed(self, atom: Atom, path: Path) -> str:
        """Return a variable for a list; numbers of a buffer are converted to one."""
        items = self._items(path)
        code = buffer_code(atom)
        if not code:
            return items
        if not path:  # the value itself, for the error report
            name = self._locals.name(path, "listed_")
            self.body.add(f"{name} = {items}")
            items = name
        listed = self._refer.function(lister(code, atom.size))
        self.body.block(f"if {items}.__class__ is not list:")
        self.body.add(f"{items} = {listed}({items})")
        self.body.end()
        return items

    def _flat(self, node: AtomArray, value: str) -> str:
        """Return the arguments for an array: its items, outermost dimension first."""
        atom, dimensions = node.atom, node.dimensions
        code = buffer_code(atom)
        if code:
            flatten = flattener(code, atom.size, dimensions)
            items = f"{self._refer.namespace.bind('flat_numbers', flatten)}({value})"
            if len(dimensions) == 1:
                items = _unless(value, "list", dimensions[0], items)
        else:
            items = f"{self._refer.function(flat)}({value}, {dimensions})"
        return f"*{each(self.convert.packed, atom, items) or items}"

    def _exact_text(self, node: TextArray, value: str) -> str:
        """Return the argument for an array of octets or characters."""
        length = node.length
        if node.text is Text.OCTETS:
            octets = f"{self._refer.function(exact_octets)}({value}, {length})"
            return _unless(value, "bytes", length, octets)
        octets = self.convert.packed_text(node.text, value)
        return f"{self._refer.function(exact)}({octets}, {length})"

    def _octets(self, node: AtomArray, path: Path) -> str:
        """Return the function that encodes an array."""
        octets = self._locals.name(path, "octets_")
        self.body.choose(octets, octets, Arrays(node), "octets")
        return octets

    def _text(self, node: TextSequence, path: Path) -> tuple[str, str]:
        if node.text is Text.OCTETS:
            octets = self._octets_in(path)
            return self._count(path, f"len({octets})", node.most), octets
        value = self._items(path) if node.text is Text.STRING else self._value(path)
        octets = self.convert.packed_text(node.text, value)
        if not octets.isidentifier():
            variable = self._locals.name(path, "octets_")
            self.body.add(f"{variable} = {octets}")
            octets = variable
        nul = " + 1" if node.text is Text.STRING else ""
        return self._count(path, f"len({octets}){nul}", node.most), octets

    def _octets_in(self, path: Path) -> str:
        """Return a variable for octets; those of a buffer are converted to `bytes`."""
        octets = self._locals.name(path, "octets_")
        self.body.add(f"{octets} = {self._value(path)}")
        self.body.block(f"if {octets}.__class__ is not bytes:")
        self.body.add(f"{octets} = {self._refer.function(octets_in)}({octets})")
        self.body.end()
        return octets

    def _records(self, node: Records, path: Path, items: str) -> str:
        pack = self._layouts.variable("pack", node)
        self.body.choose(pack, pack, self._layouts.of(node), "pack")
        arguments = [self._record_value(f, path) for f in node.fields]
        octets = self._locals.name(path, "octets_")
        packed = f"{pack}({', '.join(arguments)})"
        joined = f'{octets} = b"".join([{packed} for item in {items}])'
        if node.padding:
            joined += f"[:-{node.padding}]"
        if node.form == "list":
            self.body.add(joined)
            return octets
        put = self._locals.name(path, "put_")
        self.body.choose(put, put, Structured(node), "octets")
        self.body.block(f"if {items}.__class__ is list:")
        self.body.add(joined)
        self.body.end()
        self.body.block("else:")
        self.body.add(f"{octets} = {put}({items})")
        self.body.end()
        return octets

    def _record_value(self, field: Field, path: Path) -> str:
        value = ".".join(("item", *field.path))
        node = field.node
        match node:
            case Atom():
                return self.convert.packed(node, value)
            case AtomArray() if node.form != "list":
                inner = (*path, "[]", *field.path)
                return f"{self._octets(node, inner)}({value})"
            case AtomArray():
                return self._flat(node, value)
            case TextArray():
                return self._exact_text(node, value)
        raise TypeError(node)

    def _count(self, path: Path, expression: str, bound: int | None) -> str:
        count = self._locals.name(path, "n_")
        key = self._keys.get(path)
        chained = "" if key is None else f"{key} = "
        self.body.add(f"{count} = {chained}{expression}")
        if bound is not None:
            self._require(f"{count} > {bound}")
        return count

    def _require(self, failure: str) -> None:
        self.body.block(f"if {failure}:")
        self.body.add('raise ValueError("wrong length")')
        self.body.end()

    def _items(self, path: Path) -> str:
        """Return a variable for a collection that is used more than once."""
        value = self._value(path)
        if "." not in value:
            return value
        name = self._locals.name(path)
        self.body.add(f"{name} = {value}")
        self._bound[path] = name
        return name

    def _value(self, path: Path) -> str:
        """Return the expression for a value; enclosing structs are bound to variables."""
        if path in self._bound:
            return self._bound[path]
        parent = self._value(path[:-1])
        if "." in parent:
            name = self._locals.name(path[:-1])
            self.body.add(f"{name} = {parent}")
            self._bound[path[:-1]] = parent = name
        return f"{parent}.{path[-1]}"


def _unless(value: str, usual: str, length: int, other: str) -> str:
    """Return a value if it has the usual class and that length, else another expression."""
    usually = f"{value}.__class__ is {usual} and len({value}) == {length}"
    return f"({value} if {usually} else {other})"
