"""What the template of a union needs."""

from __future__ import annotations

from dataclasses import dataclass

from rtgen.backends.quoting.python import comment_text, string_literal
from rtgen.backends.types.constants import Layouts
from rtgen.backends.types.decoder import Decoder
from rtgen.backends.types.descriptions import Descriptions
from rtgen.backends.types.encoder import Copier, Encoder
from rtgen.backends.types.scope import Scope
from rtgen.backends.types.values import Tables
from rtgen.layouts.cdr import ANYWHERE, Atom, Form, Node, Path, Step, steps_of
from rtgen.layouts.cdr_types import CdrTypes
from rtgen.model import Case, NamedType, Union
from rtgen.typemap.idl_python import OWN_NAMES, PythonMapping, PythonNames, distinct

_DISCRIMINATOR = ("discriminator",)


@dataclass(frozen=True, slots=True)
class _Branch:
    name: str
    idl_name: str
    key: str
    type: str
    doc: str
    constructor: str
    parameters: str
    discriminator: str


@dataclass(frozen=True, slots=True)
class _Choice:
    """A branch as its codec sees it: the pattern of its labels, and its layout."""

    pattern: str
    path: Path
    node: Node
    steps: tuple[Step, ...]


@dataclass(frozen=True, slots=True)
class _Parts:
    """The layout of a union; `complete`: every discriminator has a branch by `default`."""

    switch: tuple[Step, ...]
    choices: list[_Choice]
    complete: bool


class Unions:
    """Works out branches and codecs of unions."""

    def __init__(
        self,
        names: PythonNames,
        types: CdrTypes,
        scope: Scope,
        tables: Tables,
        describe: Descriptions,
    ) -> None:
        self._names = names
        self._types = types
        self._py = scope
        self._tables = tables
        self._describe = describe

    def values(
        self, union: Union, mapping: PythonMapping, layouts: Layouts
    ) -> dict[str, object]:
        """The variables of the template but those that every class has."""
        switch = self._types.node(union.switch)
        assert isinstance(switch, Atom)
        labels = [self._labels(union, case) for case in union.cases]
        other = self._other(union, switch)
        parts = self._parts(union, switch, labels)
        types = list(dict.fromkeys(mapping.annotation(c.type) for c in union.cases))
        has_default = any(case.default for case in union.cases)
        unset = self._types.is_unset(union, union.cases[0])
        unset |= other is not None and not has_default
        if unset and "None" not in " ".join(types):
            types.append("None")
        return {
            "descriptor": self._describe.union(union),
            "switch": mapping.annotation(union.switch),
            "discriminator": (*labels[0], other)[0],
            "value_type": " | ".join(types),
            "branches": self._branches(union, mapping, labels, other),
            "encode": self._encode(switch, parts, layouts),
            "decode": self._decode(switch, parts, layouts),
            "copy": self._copy(union, parts),
        }

    def _labels(self, union: Union, case: Case) -> list[str]:
        return [self._describe.label(union, label) for label in case.labels]

    def _branches(
        self,
        union: Union,
        mapping: PythonMapping,
        labels: list[list[str]],
        other: str | None,
    ) -> list[_Branch]:
        names = self._names.members(union)
        own = {*OWN_NAMES[Union], *names.values()}
        constructors = distinct((f"of_{name}" for name in names.values()), own)
        switch = mapping.annotation(union.switch)
        branches = []
        for case, own_labels in zip(union.cases, labels, strict=True):
            name = names[case.name]
            type_ = mapping.annotation(case.type)
            choices = [*own_labels, other] if case.default and other else own_labels
            parameters = f"cls, value: {type_}"
            discriminator = choices[0]
            if len(choices) > 1 or case.default:
                parameters += f", discriminator: {switch} = {choices[0]}"
                discriminator = "discriminator"
            branches.append(
                _Branch(
                    name=name,
                    idl_name=case.name,
                    key=string_literal(case.name),
                    type=type_,
                    doc=self._doc(case),
                    constructor=constructors[f"of_{name}"],
                    parameters=parameters,
                    discriminator=discriminator or "discriminator",
                )
            )
        return branches

    def _doc(self, case: Case) -> str:
        doc = comment_text(case.doc).replace('"', "'")
        return doc or f"The value, if the branch `{case.name}` is selected."

    def _other(self, union: Union, switch: Atom) -> str | None:
        """The lowest discriminator without a label, or None if all have one."""
        used = {
            self._describe.label(union, label)
            for c in union.cases
            for label in c.labels
        }
        return next(
            (text for text in self._all(union, switch) if text not in used), None
        )

    def _all(self, union: Union, switch: Atom) -> list[str]:
        """The discriminators from the lowest on, as many as can be needed."""
        number = sum(len(case.labels) for case in union.cases) + 1
        match switch.form:
            case Form.BOOLEAN:
                return ["False", "True"]
            case Form.ENUMERATOR:
                assert switch.name is not None
                enum = self._py.reference(switch.name)
                return [f"{enum}.{m}" for m in self._names.enumerators_of(switch.name)]
            case Form.CHARACTER:
                return [string_literal(chr(n)) for n in range(min(number, 256))]
            case Form.WIDE_CHARACTER:
                return [string_literal(chr(n)) for n in range(number)]
        lowest = 0 if switch.code.isupper() else -(1 << 8 * switch.size - 1)
        return [str(lowest + n) for n in range(min(number, 1 << 8 * switch.size))]

    def _parts(self, union: Union, switch: Atom, labels: list[list[str]]) -> _Parts:
        """The branches in an order in which the wildcard pattern hides none."""
        names = self._names.members(union)
        choices = []
        for case, own in sorted(
            zip(union.cases, labels, strict=True), key=lambda pair: pair[0].default
        ):
            node = self._types.node(case.type)
            pattern = "_" if case.default else " | ".join(own)
            steps = steps_of(node, ANYWHERE)
            choices.append(_Choice(pattern, (names[case.name],), node, steps))
        complete = any(case.default for case in union.cases)
        return _Parts(steps_of(switch, ANYWHERE), choices, complete)

    def _encode(self, switch: Atom, parts: _Parts, layouts: Layouts) -> list[str]:
        encoder = Encoder(self._py, self._tables, layouts)
        body = encoder.body
        chosen = "self.discriminator"
        if switch.form in (Form.BOOLEAN, Form.ENUMERATOR):
            chosen = self._tables.packed(switch, chosen)
        body.first.append(f"discriminator = {chosen}")
        body.first.append(f"value: {self._py.Any} = self.value")
        encoder.bind(_DISCRIMINATOR, "discriminator")
        encoder.steps(parts.switch, _DISCRIMINATOR)
        body.block("match discriminator:")
        for choice in parts.choices:
            body.block(f"case {choice.pattern}:")
            encoder.bind(choice.path, "value")
            encoder.steps(choice.steps, choice.path)
            if not choice.steps:
                body.add("pass")
            body.end()
        if not parts.complete:
            body.block("case _ if value is not None:")
            body.add('raise ValueError("no branch is selected")')
            body.end()
        body.end()
        return body.lines

    def _decode(self, switch: Atom, parts: _Parts, layouts: Layouts) -> list[str]:
        decoder = Decoder(self._py, self._tables, layouts)
        body = decoder.body
        decoder.steps(parts.switch, _DISCRIMINATOR)
        body.add(f"selected = {decoder.value(switch, _DISCRIMINATOR)}")
        body.block("match selected:")
        for choice in parts.choices:
            body.block(f"case {choice.pattern}:")
            decoder.steps(choice.steps, choice.path)
            value = decoder.value(choice.node, choice.path)
            body.add(f"return cls(selected, {value}), offset")
            body.end()
        body.end()
        if not parts.complete:
            body.add("return cls(selected, None), offset")
        return body.lines

    def _copy(self, union: Union, parts: _Parts) -> list[str]:
        copier = Copier(self._py)
        body = copier.body
        body.add(f"value: {self._py.Any} = self.value")
        body.block("match self.discriminator:")
        copied = []
        holder = NamedType(union.name)
        if self._types.is_dynamic(holder) or self._types.has_headers(holder):
            return [f"return {self._py.deepcopy}(self)"]
        for choice in parts.choices:
            body.block(f"case {choice.pattern}:")
            copied.append(copier.copy(choice.node, "value", ("value",)))
            body.add("pass" if copied[-1] == "value" else f"value = {copied[-1]}")
            body.end()
        body.end()
        name = self._py.reference(union.name)
        if all(text == "value" for text in copied):
            return [f"return {name}(self.discriminator, self.value)"]
        return [*body.lines, f"return {name}(self.discriminator, value)"]
