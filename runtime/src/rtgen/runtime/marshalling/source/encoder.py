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
from rtgen.runtime.marshalling.layouts.joined import (
    aligned_element,
    formats_between,
    size_at_end,
)
from rtgen.runtime.marshalling.layouts.layout import (
    ALIGNED,
    ORIGIN,
    Frame,
    Jump,
    Loop,
    Run,
    Single,
    Step,
    has_count,
    has_varying_length,
    settled_size,
)
from rtgen.runtime.marshalling.layouts.nodes import (
    Call,
    Delimited,
    Dynamic,
    Member,
    MemberList,
    Optional,
    Parameter,
    Path,
    Repeat,
)
from rtgen.runtime.marshalling.layouts.shapes import Framed, Recurrent
from rtgen.runtime.marshalling.octets import (
    exact,
    write_reference,
)
from rtgen.runtime.marshalling.source.fields import Fields


class Encoder(Fields):
    """Generates the body of `to_cdr`, or of a function that appends to a buffer."""

    def whole(self, single: Single, base: str, number: int | None = None) -> list[str]:
        """Return the body for a value packed by one `struct` call.

        With `number`, that of its representation (big-endian), it returns the value's payload.
        """
        self._bound = {(): base}
        run, path, delimited = single
        framed = delimited or number is not None
        formats = None if framed else formats_between(run, ORIGIN)
        if formats is not None:
            parts, arguments, counts = self._joined(run, path, formats, False)
            self.body.choose("pack", "pack_all", Recurrent(run), "pack")
            self.body.add(f"packed = pack[{', '.join(counts)}]")
            self.body.block("if packed is not None:")
            self.body.add(f"return packed({', '.join(arguments)})")
            self.body.end()
            return [*self.body.lines, f'return b"".join(({", ".join(parts)}))']
        arguments, counts = self._arguments(run, path)
        if framed:
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
                    write = self._refer.dynamic_writer(dynamic.type)
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
            run = None if node.length is not None else aligned_element(node.element)
            if run is not None and self._elements(run, path, items):
                return
            self.body.block(f"for {item} in {items}:")
        self._bound[inner] = item
        self.steps(loop.steps, inner)
        self.body.end()

    def _elements(self, run: Run, path: Path, items: str) -> bool:
        """Generate the elements of a sequence, joined; False if they need more than one count."""
        counts = [field for field in run.fields if has_count(field.node)]
        formats = formats_between(run, ALIGNED)
        if formats is None and len(counts) > 1:
            return False
        body = self.body
        inner = (*path, "[]")
        item = self._bound[inner] = self._locals.name(path, "item_")
        parts = self._locals.name(path, "parts_")
        body.add(f"{parts} = []")
        pack = self._layouts.variable("pack", run)
        if formats is None:
            body.choose(pack, pack, self._layouts.of(run), "pack")
        body.block(f"for {item} in {items}:")
        if formats is None:
            arguments, (key,) = self._arguments(run, inner)
            body.add(f"{parts}.append({pack}[{key}]({', '.join(arguments)}))")
        else:
            joined, _, _ = self._joined(run, inner, formats, True)
            body.add(f"{parts} += {', '.join(joined)}")
        body.end()
        body.add(f'out += b"".join({parts})')
        size = size_at_end(run)
        assert size is not None
        if size % 4:
            count = self._locals.name((*inner, *run.fields[-1].path), "n_")
            times = "" if size == 1 else f"{size} * "
            body.block(f"if {parts}:")
            body.add(f"del out[len(out) - (-{times}{count} & 3) :]")
            body.end()
        return True
