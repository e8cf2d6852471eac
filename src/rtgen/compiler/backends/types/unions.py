"""Variables for the template of a union."""

from __future__ import annotations

import msgspec

from rtgen.compiler.backends.kit.member_texts import member_text
from rtgen.compiler.backends.kit.quoting.python import comment_text, string_literal
from rtgen.compiler.backends.types.descriptions import Descriptions
from rtgen.compiler.backends.types.scope import Scope
from rtgen.compiler.layouts.cdr_types import CdrTypes
from rtgen.compiler.model import Case, Model, NamedType, Primitive, PrimitiveType, Union
from rtgen.compiler.model.initial import discriminator, selected
from rtgen.compiler.typemap.python.idl import PythonMapping
from rtgen.compiler.typemap.python.idl_names import OWN_NAMES, PythonNames, distinct
from rtgen.facts.primitives import INTEGER_RANGES


class _Branch(msgspec.Struct, frozen=True):
    name: str
    idl_name: str
    key: str
    type: str
    doc: str
    constructor: str
    parameters: str
    discriminator: str


class Unions(msgspec.Struct, eq=False):
    """Computes the branches and codecs of unions."""

    _names: PythonNames
    _model: Model
    _types: CdrTypes
    _py: Scope
    _describe: Descriptions

    def values(
        self, union: Union, mapping: PythonMapping, representation: int
    ) -> dict[str, object]:
        """Return the variables of the template, except those common to all classes."""
        labels = [[*map(self._describe.label, c.labels)] for c in union.cases]
        other = self._other(union)
        types = list(dict.fromkeys(mapping.annotation(c.type) for c in union.cases))
        has_default = any(case.default for case in union.cases)
        first = selected(self._model, union)
        unset = first is not None and self._types.is_unset(union, first)
        unset |= other is not None and not has_default
        if unset and "None" not in " ".join(types):
            types.append("None")
        return {
            "descriptor": self._describe.union(union, representation),
            "switch": mapping.annotation(union.switch),
            "discriminator": self._describe.label(discriminator(self._model, union)),
            "value_type": " | ".join(types),
            "branches": self._branches(union, mapping, labels, other),
        }

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
        doc = comment_text(member_text(case)).replace('"', "'")
        return doc or f"The value, if the branch `{case.name}` is selected."

    def _other(self, union: Union) -> str | None:
        """Return the lowest discriminator without a label, or None if all have one."""
        used = {self._describe.label(label) for c in union.cases for label in c.labels}
        return next((text for text in self._all(union) if text not in used), None)

    def _all(self, union: Union) -> list[str]:
        """Return the discriminators in ascending order, at most as many as needed."""
        number = sum(len(case.labels) for case in union.cases) + 1
        switch = self._model.unalias(union.switch)
        if isinstance(switch, NamedType):
            enum = self._py.reference(switch.name)
            return [f"{enum}.{m}" for m in self._names.enumerators_of(switch.name)]
        assert isinstance(switch, PrimitiveType)
        match switch.kind:
            case Primitive.BOOLEAN:
                return ["False", "True"]
            case Primitive.CHAR:
                return [string_literal(chr(n)) for n in range(min(number, 256))]
            case Primitive.WCHAR:
                return [string_literal(chr(n)) for n in range(number)]
        lowest, greatest = INTEGER_RANGES[switch.kind]
        return [str(n) for n in range(lowest, min(lowest + number, greatest + 1))]
