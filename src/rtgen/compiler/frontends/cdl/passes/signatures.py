"""Pass over signatures: reads types and declared names, adds the functions of each."""

from __future__ import annotations

from rtgen.compiler.diagnostics import Related
from rtgen.compiler.frontends.cdl.names.c_types import is_void
from rtgen.compiler.frontends.cdl.names.entities import Place
from rtgen.compiler.frontends.cdl.names.scopes import Entity
from rtgen.compiler.frontends.cdl.names.table import Table
from rtgen.compiler.frontends.cdl.passes.parameters import (
    ParameterAnalysis,
    SignatureAnalysis,
)
from rtgen.compiler.frontends.cdl.passes.specifiers import belongs
from rtgen.compiler.frontends.cdl.passes.types import Types
from rtgen.compiler.frontends.cdl.rules import signatures as rules
from rtgen.compiler.frontends.cdl.rules import syntax
from rtgen.compiler.frontends.cdl.syntax import statements, tree
from rtgen.compiler.model.c_types import CPointerType, CType, CTypedefType, resolve
from rtgen.compiler.model.tecs import (
    Signature,
    TecsDirection,
    TecsFunction,
    TecsParameter,
)

_CONTEXTS = ("task", "non-task", "any")


class Signatures:
    """Lowers signatures from the syntax tree to the model."""

    def __init__(self, table: Table, types: Types) -> None:
        self._table = table
        self._types = types

    def signature(
        self,
        item: statements.Item,
        node: statements.Signature,
        place: Place,
        entity: Entity,
    ) -> Signature | None:
        """Return the model of a signature; None, after diagnostics, if it has errors."""
        made = _Signature(self._table, self._types, place)
        context = made.context(item)
        deviate = item.specifier("deviate") is not None
        made.deviate = deviate
        functions = made.functions(node)
        if functions is None:
            return None
        return Signature(
            name=entity.name,
            file=place.unit.source.name,
            span=entity.place,
            doc=place.doc(item),
            functions=functions,
            context=context,
            callback=item.specifier("callback") is not None,
            deviate=deviate,
        )


class _Signature(SignatureAnalysis):
    """Analyses one signature and its functions."""

    def context(self, item: statements.Item) -> str:
        found: str | None = None
        for specifier in item.specifiers.items if item.specifiers else ():
            if specifier.word == "context":
                if found is not None:
                    message = "'context' is given already"
                    self._report(rules.SPECIFIER_TWICE, specifier, message)
                (argument,) = specifier.arguments
                assert isinstance(argument, tree.Text)
                found = argument.text
                if found not in _CONTEXTS:
                    message = f'the context "{found}" is unknown'
                    hint = "it is task, non-task or any"
                    self._report(rules.CONTEXT_UNKNOWN, argument, message, hint)
        return found if found is not None else "task"

    def functions(self, node: statements.Signature) -> tuple[TecsFunction, ...] | None:
        found: dict[str, TecsFunction] = {}
        good = True
        number = 0
        for item in node.functions:
            if not isinstance(item.node, statements.Function):
                good = False
                continue
            number += 1
            function = self._function(item, item.node, number)
            if function is None:
                good = False
            elif function.name in found:
                self._table.report(
                    rules.FUNCTION_TWICE.at(
                        function.span,
                        f"the function '{function.name}' is declared already",
                        related=[
                            Related(found[function.name].span, "first declared here")
                        ],
                    )
                )
                good = False
            else:
                found[function.name] = function
        return tuple(found.values()) if good else None

    def _function(
        self, item: statements.Item, node: statements.Function, number: int
    ) -> TecsFunction | None:
        oneway = False
        for specifier in item.specifiers.items if item.specifiers else ():
            if specifier.word == "oneway" and oneway:
                message = "'oneway' is given already"
                self._report(rules.SPECIFIER_TWICE, specifier, message)
            elif specifier.word == "oneway":
                oneway = True
            else:
                message = f"'{specifier.word}' cannot precede a function"
                hint = belongs(specifier.word)
                self._report(syntax.MISPLACED_SPECIFIER, specifier, message, hint)
        name = node.declarator.name
        assert name is not None
        suffix = node.declarator.suffixes[0] if node.declarator.suffixes else None
        if (
            not isinstance(suffix, tree.Parameters)
            or len(node.declarator.suffixes) > 1
            or isinstance(node.declarator.inner, tree.Declarator)
        ):
            self._report(
                rules.NOT_A_FUNCTION,
                name,
                f"'{name.text}' is not a function",
                "put its parameters after it, or ( void )",
            )
            return None
        types = self._types
        base = types.of(node.type, self._place, name.text)
        returned = tree.Declarator(
            node.start, node.end, node.declarator.pointers, None, ()
        )
        returns = types.declared(base, returned, self._place)
        if not suffix.items:
            message = f"'{name.text}' has no parameters"
            self._report(rules.NO_VOID, suffix, message, "write ( void )")
        parameters = ParameterAnalysis(
            self._table, self._types, self._place, self.deviate
        ).of(suffix)
        if returns is None:
            return None
        if isinstance(resolve(returns), CPointerType) and not self.deviate:
            message = f"'{name.text}' returns a pointer"
            hint = "give it back by an out parameter, or write [deviate] before the signature"
            self._report(rules.RETURNS_POINTER, name, message, hint)
        if not is_void(returns) and not types.is_value(returns, self._place, name):
            return None
        if parameters is None:
            return None
        if oneway and not self._can_be_oneway(name, returns, parameters):
            return None
        return TecsFunction(
            id=number,
            name=name.text,
            returns=returns,
            parameters=parameters,
            oneway=oneway,
            span=self._place.span(name),
            doc=self._place.doc(item),
        )

    def _can_be_oneway(
        self, name: tree.Name, returns: CType, parameters: tuple[TecsParameter, ...]
    ) -> bool:
        good = True
        error = isinstance(returns, CTypedefType) and returns.name[-1] == "ER"
        if not (is_void(returns) or error):
            message = f"the oneway function '{name.text}' returns {returns}"
            self._report(rules.ONEWAY_RETURN, name, message, "return void or ER")
            good = False
        for parameter in parameters:
            if parameter.direction not in (TecsDirection.IN, TecsDirection.SEND):
                message = (
                    f"'{parameter.name}' of the oneway function '{name.text}' is "
                    f"{parameter.direction}"
                )
                self._table.report(
                    rules.ONEWAY_PARAMETER.at(
                        parameter.span, message, hint="it can be in or send"
                    )
                )
                good = False
        return good
