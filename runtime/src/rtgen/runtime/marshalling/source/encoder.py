"""Generates the source text of functions that marshal a value, from its layout."""

from __future__ import annotations

from typing import Any

from rtgen.runtime.marshalling.layouts.headers import (
    LONG_MUST_UNDERSTAND,
    PID_EXTENDED,
    SHORT_MUST_UNDERSTAND,
    Lengths,
    MemberHeaders,
    Parameters,
)
from rtgen.runtime.marshalling.layouts.layout import (
    Frame,
    Jump,
    Loop,
    Run,
    Single,
    Step,
    has_varying_length,
    settled_size,
)
from rtgen.runtime.marshalling.layouts.nodes import (
    Atom,
    AtomArray,
    AtomSequence,
    Call,
    Delimited,
    Dynamic,
    Field,
    Form,
    Header,
    Member,
    MemberList,
    Node,
    Optional,
    Parameter,
    Path,
    Records,
    Repeat,
    Text,
    TextArray,
    TextSequence,
)
from rtgen.runtime.marshalling.layouts.shapes import Framed, Layouts
from rtgen.runtime.marshalling.octets import (
    exact,
    exact_octets,
    flat,
    octets_in,
    write_reference,
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


class Encoder:
    """Generates the body of `to_cdr`, or of a function that appends to a buffer."""

    def __init__(self, references: References) -> None:
        self._refer = references
        self.convert = Conversions(references.namespace)
        self._layouts = Layouts()
        self._locals = Locals(references.namespace)
        self._bound: dict[Path, str] = {}
        self._keys: dict[Path, str] = {}
        self.body = Body(references.namespace)

    def whole(self, single: Single, base: str, number: int | None = None) -> list[str]:
        """Return the body for a value packed by one `struct` call.

        With `number`, that of its representation (big-endian), it returns the value's payload.
        """
        self._bound = {(): base}
        run, path, delimited = single
        arguments, counts = self._arguments(run, path)
        if delimited or number is not None:
            layout: Any = Framed(run, number, delimited)
        else:
            layout = self._layouts.of(run, whole=True)
        self.body.choose("pack", "pack_all", layout, "pack")
        shape = f"[{', '.join(counts)}]" if counts else ""
        return [*self.body.lines, f"return pack{shape}({', '.join(arguments)})"]

    def parts(self, steps: tuple[Step, ...], base: str) -> list[str]:
        """Return the body for a value whose parts are appended to `out`."""
        self._bound = {(): base}
        self.steps(steps, ())
        return self.body.lines

    def steps(self, steps: tuple[Step, ...], prefix: Path) -> None:
        """Generate the steps of the value at path `prefix`."""
        for step in steps:
            match step:
                case Run():
                    self._run(step, prefix)
                case Loop(path=path, node=node):
                    self._loop(step, (*prefix, *path), node)
                case Frame(path=path):
                    self._frame(step, (*prefix, *path))
                case Jump(path=path, node=Call() as node):
                    value = self._value((*prefix, *path))
                    write = self._refer.writer(node.type)
                    self.body.add(f"{write}({value}, out, little_endian)")
                case Jump(path=path, node=Dynamic() as dynamic):
                    value = self._value((*prefix, *path))
                    described = self._refer.descriptor(dynamic.type)
                    write = self._refer.dynamic_writer()
                    self.body.add(f"{write}(out, {value}, {described}, little_endian)")
                case Jump(path=path):
                    value = self._value((*prefix, *path))
                    write = self._refer.function(write_reference)
                    self.body.add(f"{write}(out, {value}, little_endian)")

    def _frame(self, frame: Frame, path: Path) -> None:
        body = self.body
        node = frame.node
        match node:
            case Optional():
                body.block(f"if {self._items(path)} is None:")
                body.add('out += b"\\0"')
                body.end()
                body.block("else:")
                body.add('out += b"\\1"')
                self.steps(frame.steps, path)
                body.end()
            case Delimited():
                start = self._locals.name(path, "start_")
                self.begin_delimited(start)
                self.steps(frame.steps, path)
                self.put_length(start)
            case MemberList():
                self.steps(frame.steps, path)
                if self._refer.format.version == 1:
                    self.end_list()
            case Member() | Parameter():
                self.headed(node, frame.steps, path)

    def headed(
        self, node: Member | Parameter, steps: tuple[Step, ...], path: Path
    ) -> None:
        """Generate a member with a header of its own, omitted if it is optional and None."""
        if not node.optional:
            self._headed(node, steps, path)
            return
        value = self._items(path)
        self.body.block(f"if {value} is not None:")
        self._headed(node, steps, path)
        self.body.end()
        if isinstance(node, Parameter) and not node.in_list:
            self.body.block("else:")
            self._parameter(node, "0")
            self.body.end()

    def _headed(
        self, node: Member | Parameter, steps: tuple[Step, ...], path: Path
    ) -> None:
        body = self.body
        match node:
            case Member() if has_varying_length(node):
                # The content may have a length of its own at the same path: `start_`.
                start = self._locals.name(path, "begin_")
                body.add("out += bytes((-len(out) & 3) + 8)")
                body.add(f"{start} = len(out)")
                self.steps(steps, path)
                body.choose("put_header", "put_header", MemberHeaders, "put")
                length = f"len(out) - {start}"
                body.add(f"put_header(out, {start} - 8, {node.header}, {length})")
            case Member():
                self.steps(steps, path)
            case Parameter():
                size = settled_size(steps)
                padding = 0 if size is None or not node.in_list else -size & 3
                if size is not None:
                    self._parameter(node, str(size + padding))
                    self.steps(steps, path)
                    if padding:
                        body.add(f"out += bytes({padding})")
                    return
                outer = self._locals.name(path, "outer_")
                body.add(f"{outer} = out")
                body.add("out = bytearray()")
                self.steps(steps, path)
                if node.in_list:
                    body.add("out += bytes(-len(out) & 3)")
                content = self._locals.name(path, "content_")
                body.add(f"{content} = out")
                body.add(f"out = {outer}")
                self._parameter(node, f"len({content})")
                body.add(f"out += {content}")

    def _parameter(self, node: Parameter, size: str) -> None:
        """Generate the header of a parameter in the extended form."""
        pid = PID_EXTENDED | SHORT_MUST_UNDERSTAND
        flags = node.must_understand * LONG_MUST_UNDERSTAND | node.id
        self.body.choose("pack_header", "pack_header", Parameters, "pack")
        header = f"pack_header({pid}, 8, {flags}, {size})"
        self.body.add(f"out += bytes(-len(out) & 3) + {header}")

    def end_list(self) -> None:
        """Generate the parameter that ends a list of XCDR1."""
        self.body.choose("list_end", "list_end", Parameters, "end")
        self.body.add("out += bytes(-len(out) & 3) + list_end")

    def begin_delimited(self, start: str) -> None:
        """Generate a placeholder of the DHEADER; the value starts at the offset in a variable."""
        self.body.add('out += bytes(-len(out) & 3) + b"\\0\\0\\0\\0"')
        self.body.add(f"{start} = len(out)")

    def put_length(self, start: str) -> None:
        """Generate the DHEADER of a value that starts at the offset in a variable."""
        self.body.choose("put", "put", Lengths, "put")
        self.body.add(f"put(out, {start} - 4, len(out) - {start})")

    def bind(self, path: Path, expression: str) -> None:
        """Use the expression for the value at the path."""
        self._bound[path] = expression

    def _run(self, run: Run, prefix: Path) -> None:
        arguments, counts = self._arguments(run, prefix)
        pack = self._layouts.variable("pack", run)
        self.body.choose(pack, pack, self._layouts.of(run), "pack")
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
                items = f"{self._refer.function(exact)}({items}, {node.length})"
            if not loop.steps:  # empty elements
                self.body.add(items)
                return
            self.body.block(f"for {item} in {items}:")
        self._bound[inner] = item
        self.steps(loop.steps, inner)
        self.body.end()

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
