"""Generates the source text of functions that unmarshal a value, from its layout."""

from __future__ import annotations

from rtgen.runtime.marshalling.layouts.headers import next_member, next_parameter
from rtgen.runtime.marshalling.layouts.layout import (
    ALIGNED,
    ANYWHERE,
    ORIGIN,
    Entry,
    Frame,
    Jump,
    Loop,
    Run,
    Step,
    steps_of,
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
    Group,
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
from rtgen.runtime.marshalling.layouts.overlapping import Overlapping, overlapping
from rtgen.runtime.marshalling.octets import nested, read_reference
from rtgen.runtime.marshalling.source.bulk import Arrays
from rtgen.runtime.marshalling.source.conversions import Conversions, each
from rtgen.runtime.marshalling.source.references import References
from rtgen.runtime.marshalling.source.repeated import Repeated
from rtgen.runtime.marshalling.source.sections import Sections

EMPTY_ELEMENTS = 65536
"""Maximum number of elements without octets in a collection."""

_MAX_COMPARED = 8
"""Maximum number of ids that are compared one by one."""


class Decoder(Sections):
    """Generates the body of `from_cdr`, or of a function that reads at an offset."""

    def __init__(self, references: References) -> None:
        super().__init__(references)
        self._convert = Conversions(references.namespace)
        self.cut = False
        """Whether `data` is only a part of the data in some branch."""

    def fixed(self, run: Run, node: Node, *, exact: bool = True) -> list[str]:
        """Return the body for a value of fixed size, unpacked by one `struct` call.

        Not `exact`: data may follow it.
        """
        if not exact:
            size = run.sections[0].size
            self.body.block(f"if len(data) > {size}:")
            self.body.add(f"data = data[:{size}]")
            self.body.end()
        entries = run.sections[0].entries
        layout = self._layouts.of(run, whole=True)
        self.body.choose("unpack", "unpack_all", layout, "unpack")
        self._assign(self._targets(entries, ()), "unpack(data)")
        return self._returning(self.value(node, (), True))

    def whole(
        self, steps: tuple[Step, ...], node: Node, *, exact: bool = True
    ) -> list[str]:
        """Return the body for a value that must use all data, or not if it is not `exact`."""
        self._offset = 0
        self.steps(steps, ())
        end = self._offset if self._offset is not None else "offset"
        self.body.block(f"if {end} != len(data):")
        value = self.value(node, (), True)
        self.body.add(
            'raise ValueError("octets too many")' if exact else f"return {value}"
        )
        self.body.end()
        return self._returning(value)

    def repeated(self, lines: list[str], run: Step, title: str) -> list[str]:
        """Return the body of `whole` for one run, with specialised readers for repeated shapes."""
        assert isinstance(run, Run)
        value = lines[-1].removeprefix("return ")
        layout = self._layouts.of(run)
        title = f"{self._refer.format} from_cdr of {title}"
        readers = Repeated(
            run, layout, self._name, self._further, value, self._refer.namespace, title
        )
        return readers.lines(lines)

    def parts(self, steps: tuple[Step, ...], node: Node) -> list[str]:
        """Return the body for a value inside other data; its end offset is returned, too."""
        self.steps(steps, ())
        return self._returning(f"{self.value(node, ())}, offset")

    def _returning(self, value: str) -> list[str]:
        return [*self.body.lines, f"return {value}"]

    def steps(self, steps: tuple[Step, ...], prefix: Path) -> None:
        """Generate the steps of the value at path `prefix`."""
        for step in steps:
            match step:
                case Run():
                    self._run(step, prefix)
                case Loop():
                    self._loop(step, (*prefix, *step.path))
                case Frame():
                    self._frame(step, (*prefix, *step.path))
                case Jump(path=path, node=node):
                    self._settle()
                    name = self._locals.name((*prefix, *path))
                    arguments = "data, offset, little_endian"
                    if isinstance(node, Call):
                        read = self._refer.reader(node.type)
                    elif isinstance(node, Dynamic):
                        read = self._refer.dynamic_reader(node.type)
                        described = self._refer.descriptor(node.type)
                        arguments = f"data, offset, {described}, little_endian"
                    else:
                        read = self._refer.function(read_reference)
                    self.body.add(f"{name}, offset = {read}({arguments})")

    def _frame(self, frame: Frame, path: Path) -> None:
        self._settle()
        node = frame.node
        match node:
            case Optional():
                self._optional(frame, node, path)
            case Parameter():
                self._parameter(node, path)
            case MemberList(members=members):
                self.listed(members, path)
            case Delimited(node=inner):
                end = self._locals.name(path, "end_")
                self.take_length(end)
                if isinstance(inner, MemberList):
                    self.listed(inner.members, path, end)
                    return
                self.steps(frame.steps, path)
                self._settle()
                self.refuse(f"offset != {end}")

    def _optional(self, frame: Frame, node: Optional, path: Path) -> None:
        body = self.body
        name = self._locals.name(path)
        present = self._locals.name(path, "has_")
        body.add(f"{present} = data[offset]")
        body.add("offset += 1")
        body.block(f"if {present} == 1:")
        self.steps(frame.steps, path)
        self._settle()
        body.add(f"{name} = {self.value(node.node, path)}")
        body.end()
        body.block("else:")
        self.refuse(present, "a flag that is not a boolean")
        body.add(f"{name} = None")
        body.end()

    def _parameter(self, node: Parameter, path: Path) -> None:
        """Generate an optional member in XCDR1 outside of a list; an empty parameter means
        absent.
        """
        body = self.body
        name, stop = self._locals.name(path), self._locals.name(path, "stop_")
        read = self._refer.function(next_parameter)
        body.add(
            f"member, required, offset, {stop} = {read}(data, offset, little_endian)"
        )
        self.refuse(f"member != {node.id}", f"the parameter {node.id} is needed")
        body.add(f"{name} = None")
        body.block(f"if offset != {stop}:")
        self._content(node, path, stop, name)
        body.end()

    def listed(
        self,
        members: tuple[tuple[str, Member | Parameter], ...],
        path: Path,
        end: str | None = None,
    ) -> None:
        """Generate members in any order, by attribute in a dict: up to `end`, or a list's end."""
        body = self.body
        found, stop = self.found(path), self._locals.name(path, "stop_")
        body.add(f"{found} = {{}}")
        if end is not None:
            self.refuse(f"{end} > len(data)", "a length beyond the end")
            read = self._refer.function(next_member)
            body.block(f"while offset < {end}:")
            arguments = f"data, offset, {end}, little_endian"
        else:
            read = self._refer.function(next_parameter)
            body.block("while True:")
            arguments = "data, offset, little_endian"
        body.add(f"member, required, offset, {stop} = {read}({arguments})")
        if end is None:
            self._break("member < 0")
        self._select(sorted(members, key=lambda m: m[1].id), path, stop)
        body.end()
        for attribute, member in members:
            if member.key:
                self.refuse(f"{attribute!r} not in {found}", "a key is missing")

    def found(self, path: Path) -> str:
        """Return the variable for the members found in a list."""
        return self._locals.name(path, "found_")

    def _select(
        self, members: list[tuple[str, Member | Parameter]], path: Path, stop: str
    ) -> None:
        """Generate reading the member of the id in `member`; an unknown one is skipped."""
        body = self.body
        if len(members) > _MAX_COMPARED:
            half = len(members) // 2
            body.block(f"if member < {members[half][1].id}:")
            self._select(members[:half], path, stop)
            body.end()
            body.block("else:")
            self._select(members[half:], path, stop)
            body.end()
            return
        found = self.found(path)
        word = "if"
        for attribute, member in members:
            body.block(f"{word} member == {member.id}:")
            self.refuse(f"{attribute!r} in {found}", "the member stands twice")
            inner = (*path, attribute)
            self._content(member, inner, stop, f"{found}[{attribute!r}]")
            body.end()
            word = "elif"
        body.block("elif required:" if members else "if required:")
        body.add('raise ValueError("a member that must be understood")')
        body.end()
        body.block("else:")
        body.add(f"offset = {stop}")
        body.end()

    def _content(
        self, node: Member | Parameter, path: Path, stop: str, target: str
    ) -> None:
        """Generate a member's value, which fills the octets up to `stop` except for padding."""
        body = self.body
        if isinstance(node, Member):
            self.steps(steps_of(node.node, ALIGNED), path)
            self._settle()
            self.refuse(f"offset != {stop}")
            body.add(f"{target} = {self.value(node.node, path)}")
            return
        outer = self._locals.name(path, "outer_")
        body.add(f"{outer} = data")
        body.add(f"data = memoryview(data)[offset:{stop}]")
        self.cut = True
        self._offset = 0
        self.steps(steps_of(node.node, ORIGIN), path)
        self._settle()
        end = (
            "offset <= len(data) < offset + 4"
            if node.in_list
            else "offset == len(data)"
        )
        self.refuse(f"not {end}")
        body.add(f"{target} = {self.value(node.node, path)}")
        body.add(f"data = {outer}")
        body.add(f"offset = {stop}")

    def evolving(self, group: Group, end: str) -> None:
        """Generate the members present up to `end`, in `values`; further octets are ignored."""
        body = self.body
        body.add("values = []")
        body.block("while True:")
        for attribute, node in group.members:
            self._break(f"offset >= {end}")
            self.steps(steps_of(node, ANYWHERE), (attribute,))
            self._settle()
            body.add(f"values.append({self.value(node, (attribute,))})")
        body.add("break")
        body.end()

    def _break(self, condition: str) -> None:
        self.body.block(f"if {condition}:")
        self.body.add("break")
        self.body.end()

    def value(self, node: Node, path: Path, outermost: bool = False) -> str:
        """Return the expression for a value, given its unpacked items."""
        convert = self._convert
        match node:
            case Group(type=type_, members=members):
                class_ = "cls" if outermost else self._refer.made(type_)
                inner = [self.value(n, (*path, m)) for m, n in members]
                return f"{class_}({', '.join(inner)})"
            case Records(form="list"):
                return self._records(node, path)
            case MemberList(type=type_):
                class_ = "cls" if outermost else self._refer.made(type_)
                return f"{class_}(**{self.found(path)})"
            case Delimited(node=inner):
                return self.value(inner, path, outermost)
        raw = self._locals.name(path)
        match node:
            case Atom():
                return convert.unpacked(node, raw)
            case AtomArray() if node.form != "list":
                return f"{self._array_maker(node, path)}({raw})"
            case AtomArray(atom=atom, dimensions=dimensions):
                items = each(convert.unpacked, atom, raw) or raw
                if len(dimensions) == 1:
                    return items
                return f"{self._refer.function(nested)}({items}, {dimensions})"
            case AtomSequence(atom=Atom(form=Form.WORD)):
                return convert.worded(raw)
            case AtomSequence(atom=atom):
                return each(convert.unpacked, atom, raw) or raw
            case TextArray(text=text):
                return convert.unpacked_text(text, raw)
            case TextSequence(text=Text.STRING):
                return convert.unpacked_string(raw, self._locals.name(path, "nul_"))
            case TextSequence(text=text, bound=bound):
                return convert.unpacked_text(text, raw, bound)
        return raw

    def _array_maker(self, node: AtomArray, path: Path) -> str:
        """Return the function that makes an array from octets."""
        name = self._locals.name(path, "made_")
        self.body.choose(name, name, Arrays(node), "made")
        return name

    def _loop(self, loop: Loop, path: Path) -> None:
        node = loop.node
        self._settle()
        count = str(node.length)
        if node.length is None:
            count = self._locals.name(path, "n_")
            least = f"{count} * {node.minimum}" if node.minimum > 1 else count
            most = "len(data) - offset" if node.minimum else str(EMPTY_ELEMENTS)
            self.refuse(f"{least} > {most}", "a length beyond the end")
        items = self._locals.name(path)
        self.body.add(f"{items} = {'{}' if node.key is not None else '[]'}")
        if node.key is None and node.length is None:
            runs = overlapping(node.element)
            if runs is not None:
                self._overlapping(runs, node, path, count)
                return
        self.body.block(f"for _ in range({count}):")
        if node.key is not None:
            self.steps(loop.key_steps, (*path, "{}"))
            key = self.value(node.key, (*path, "{}"))
            variable = self._locals.name(path, "key_")
            self.body.add(f"{variable} = {key}")
        self.steps(loop.steps, (*path, "[]"))
        value = self.value(node.element, (*path, "[]"))
        if node.key is not None:
            self.body.add(f"{items}[{variable}] = {value}")
        else:
            self.body.add(f"{items}.append({value})")
        self.body.end()
        if node.key is not None:
            self.refuse(f"len({items}) != {count}", "a key that is there twice")

    def _overlapping(
        self, runs: Overlapping, node: Repeat, path: Path, count: str
    ) -> None:
        """Generate the elements of a sequence, each read with the beginning of the next."""
        body = self.body
        inner = (*path, "[]")
        body.block(f"if {count}:")
        self._run(runs.first, inner)
        *readers, reader = self._chosen(runs.rest)
        (last,) = self._chosen(runs.last)
        each_reader = self._locals.name(path, "read_")
        body.block(f"for {each_reader} in [{reader}] * ({count} - 1) + [{last}]:")
        *sections, final = runs.rest.sections
        for section, read in zip(sections, readers, strict=True):
            self._section(section, read, inner)
        self._following = runs.following
        self._section(final, each_reader, inner)
        self._following = ()
        value = self.value(node.element, inner)
        body.add(f"{self._locals.name(path)}.append({value})")
        for entry in runs.following:
            if not entry.count:
                field = (*inner, *entry.field.path)
                following = self._locals.name(field, "next_")
                body.add(f"{self._locals.name(field)} = {following}")
        body.end()
        body.end()

    def _records(self, node: Records, path: Path) -> str:
        records = self._layouts.variable("records", node)
        self.body.choose(records, records, self._layouts.of(node), "records")
        inner = _Record(self._refer)
        inner.body = self.body
        targets = inner.targets(node.fields)
        value = inner.value(node.element, ())
        octets = self._locals.name(path)
        if node.padding:
            octets = f"{octets} and {octets} + {bytes(node.padding)!r}"
        return f"[{value} for {targets} in {records}({octets})]"


class _Record(Decoder):
    """Values of an element in a sequence of records, inside a comprehension."""

    def targets(self, fields: tuple[Field, ...]) -> str:
        """Return the variables of an element."""
        entries = (Entry(f, star=_is_star(f.node)) for f in fields)
        return self._targets(tuple(entries), ())


def _is_star(node: Node) -> bool:
    """Return whether `struct` unpacks several values for a field."""
    return isinstance(node, AtomArray) and node.form == "list"
