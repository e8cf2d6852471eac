"""Checks `factory` and `FACTORY` against attributes and variables; records who has a factory."""

from __future__ import annotations

import re

from rtgen.compiler.diagnostics import Related
from rtgen.compiler.frontends.cdl.names.entities import (
    Celltype,
    Report,
    Values,
    Variable,
)
from rtgen.compiler.frontends.cdl.passes.constants import is_character
from rtgen.compiler.frontends.cdl.rules import celltypes as rules
from rtgen.compiler.frontends.cdl.syntax import statements, tree
from rtgen.compiler.frontends.kit.suggestions import nearest
from rtgen.compiler.model.c_types import CPointerType, resolve

_CONVERSION = re.compile(
    r"%(?P<flags>[-+ #0]*[\d*]*(?:\.[\d*]+)?)(?P<letter>.|$)", re.S
)
_NUMBERS = frozenset("diouxXbBeEfgGaA")
_LETTERS = _NUMBERS | frozenset("csp")


class Factories:
    """Checks the factories of celltypes."""

    def __init__(self, values: Values, report: Report) -> None:
        self._values = values
        self._report = report

    def take(self, type_: Celltype, node: statements.Factory) -> None:
        """Check the calls of a factory, and record that the celltype has one."""
        place = type_.place
        for item in node.items:
            call = item.node
            if not isinstance(call, statements.FactoryCall):
                continue
            if node.keyword == "factory":
                type_.cell_factory = True
            else:
                type_.celltype_factory = True
            if call.function.text != "write":
                self._report(
                    rules.UNKNOWN_FACTORY_FUNCTION.at(
                        place.span(call.function),
                        f"there is no function {call.function.text} in a factory",
                        hint="the only one is write",
                    )
                )
                continue
            for what, text in (
                ("name of the file", call.file),
                ("format", call.format),
            ):
                if not isinstance(self._values.constant(text, place), str):
                    self._report(
                        rules.FACTORY_TEXT.at(
                            place.span(text),
                            f"the {what} is not a string",
                            hint='put it between " "',
                        )
                    )
            self._arguments(type_, node, call)

    def _arguments(
        self, type_: Celltype, node: statements.Factory, call: statements.FactoryCall
    ) -> None:
        place = type_.place
        if node.keyword == "FACTORY" and call.arguments:
            first, last = call.arguments[0], call.arguments[-1]
            self._report(
                rules.FACTORY_ARGUMENT.at(
                    place.unit.span(first.start, last.end),
                    "FACTORY is for the celltype as a whole and has no values of a cell",
                    hint="use factory, which writes for each cell",
                )
            )
            return
        if call.arguments:
            self._format(type_, call)
        for argument in call.arguments:
            if isinstance(argument, tree.Text):
                continue
            found = type_.members.get(argument.text)
            if isinstance(found, Variable) and found.kind == "attr":
                continue
            attributes = [v.name for v in type_.variables if v.kind == "attr"]
            near = nearest(argument.text, attributes)
            state = "is not an attribute" if found else "is not known"
            self._report(
                rules.FACTORY_ARGUMENT.at(
                    place.span(argument),
                    f"{argument.text} {state}; it must be an attribute declared before",
                    related=[Related(found.span, "declared here")] if found else [],
                    hint=f"did you mean {near}?" if near else None,
                )
            )

    def _format(self, type_: Celltype, call: statements.FactoryCall) -> None:
        """Return whether the format matches its arguments by the rules of Ruby's `printf`."""
        text = self._values.constant(call.format, type_.place)
        if not isinstance(text, str):
            return
        left = list(call.arguments)
        message = None
        for found in _CONVERSION.finditer(text):
            letter = found["letter"]
            if letter == "%" and not found["flags"]:
                continue
            if letter in "$<{" and letter:
                return  # arguments by number or name
            if letter not in _LETTERS:
                message = f"{found[0]!r} is not a conversion"
            elif not left:
                message = (
                    f"the format has more places than values ({len(call.arguments)})"
                )
            elif letter in _NUMBERS and _is_no_number(type_, left.pop(0)):
                message = f"{found[0]} wants a number"
            elif letter not in _NUMBERS:
                left.pop(0)
            if message is not None:
                span = type_.place.span(call.format)
                self._report(rules.FACTORY_FORMAT.at(span, message))
                return


def _is_no_number(type_: Celltype, argument: tree.Name | tree.Text) -> bool:
    if isinstance(argument, tree.Text):
        return not argument.text.lstrip("-").isdecimal()
    found = type_.members.get(argument.text)
    if not isinstance(found, Variable) or found.type is None:
        return False
    kind = resolve(found.type)
    if isinstance(kind, CPointerType):
        return is_character(kind.target)
    return isinstance(found.value, tree.Boolean)
