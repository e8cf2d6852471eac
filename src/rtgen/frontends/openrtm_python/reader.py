"""The component that a module of OpenRTM-aist-Python makes, as far as it is written out."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Sequence

from rtgen.diagnostics import Diagnostic, Rule, Span
from rtgen.frontends.openrtm_python import rules
from rtgen.frontends.openrtm_python.outline import (
    Body,
    component_classes,
    module_spec,
)
from rtgen.frontends.openrtm_python.values import (
    GENERATED_VARIABLE,
    Imports,
    argument,
    called,
    dotted,
    text,
    variable,
)
from rtgen.frontends.rtc_profile.names import ACTIVITY_TYPES, COMPONENT_TYPES
from rtgen.model.constraints import ConstraintError, parse
from rtgen.model.rtc_profile import (
    ProfileDataPort,
    ProfileInterface,
    ProfileParameter,
    ProfileServicePort,
    RtcProfile,
)

_BASE = "DataFlowComponentBase"
_PROPERTIES = ("__widget__", "__constraints__", "__type__")
_KNOWN = frozenset(
    (
        *("implementation_id", "type_name", "description", "version", "vendor"),
        *("category", "activity_type", "max_instance", "language", "lang_type"),
        *("exec_cxt.periodic.rate", "exec_cxt.periodic.type", ""),
    )
)
_CALLBACKS = tuple(
    f"on{name}"
    for name in (
        *("Finalize", "Startup", "Shutdown", "Activated", "Deactivated", "Execute"),
        *("Aborting", "Error", "Reset", "StateUpdate", "RateChanged"),
    )
)
_ADD_DATA_PORT = ("addInPort", "addOutPort", "registerInPort", "registerOutPort")
_ADD_SERVICE_PORT = ("addPort", "registerPort")
_DATA_PORTS = ("InPort", "OutPort")
_WORDS = {bool: "bool", int: "int", float: "double", str: "string"}
_DATE = "1970-01-01T00:00:00+00:00"


class ModuleReader:
    """Reads one module; what could not be carried over is in `diagnostics`."""

    def __init__(self, file: str) -> None:
        self.diagnostics: list[Diagnostic] = []
        self._file = file
        self._imports = Imports()
        self._body = Body()

    @property
    def generated(self) -> bool:
        """Whether it is a module that rtgen makes."""
        return self._imports.generated

    def profile(self, tree: ast.Module) -> RtcProfile | None:
        """The component, None if there is none."""
        for node in ast.walk(tree):
            if isinstance(node, ast.stmt):
                self._imports.note(node)
        spec = module_spec(tree)
        classes = component_classes(tree)
        if spec is None or not classes:
            what = "module spec" if spec is None else f"class that derives from {_BASE}"
            start = Span(self._file, 1, 1, 1, 2)
            self._tell(rules.NO_COMPONENT, start, f"there is no {what}")
            return None
        place, items = spec
        made = classes[0]
        # What a base does comes first, as its __init__ and onInitialize are called first.
        for each in reversed(classes):
            self._body.take(each)
            self._told_callbacks(each)
        values = dict(self._pairs(items))
        self._told_entries(place, values)
        kind = values.get("activity_type", "")
        return RtcProfile(
            file=self._file,
            span=self._span(made),
            format_version="0.3",
            name=values.get("implementation_id") or made.name,
            vendor=values.get("vendor", ""),
            category=values.get("category", ""),
            version=values.get("version") or "1.0.0",
            description=values.get("description", ""),
            doc=_own_text(ast.get_docstring(made)),
            component_type=kind if kind in COMPONENT_TYPES else "STATIC",
            activity=kind if kind in ACTIVITY_TYPES else "PERIODIC",
            kind="DataFlowComponent",
            execution=values.get("exec_cxt.periodic.type", "PeriodicExecutionContext"),
            rate=_positive(values.get("exec_cxt.periodic.rate", "")),
            max_instances=_count(values.get("max_instance", "")),
            created=_DATE,
            updated=_DATE,
            parameters=tuple(self._parameters(place, values)),
            data_ports=tuple(self._data_ports()),
            service_ports=tuple(self._service_ports()),
        )

    def _tell(
        self, rule: Rule, span: Span, message: str, hint: str | None = None
    ) -> None:
        self.diagnostics.append(rule.at(span, message, hint=hint))

    def _span(self, node: ast.AST) -> Span:
        line = getattr(node, "lineno", 1)
        column = getattr(node, "col_offset", 0) + 1
        end = getattr(node, "end_lineno", line)
        end_column = getattr(node, "end_col_offset", column) + 1
        if isinstance(node, ast.ClassDef):
            end, end_column = line, column + len("class ") + len(node.name)
        return Span(self._file, line, column, end, end_column)

    # The module spec and the class.

    def _pairs(self, items: Sequence[ast.expr]) -> Iterator[tuple[str, str]]:
        for key, value in zip(items[::2], items[1::2], strict=False):
            name, told = text(key), text(value)
            if name is None or told is None:
                message = f"the entry {name or ''} of the module spec is computed"
                self._tell(rules.COMPUTED, self._span(value), message)
            else:
                yield name, told

    def _told_callbacks(self, made: ast.ClassDef) -> None:
        bodies = [
            node.name
            for node in made.body
            if isinstance(node, ast.FunctionDef)
            and node.name in _CALLBACKS
            and not _is_empty(node)
        ]
        if bodies:
            message = f"the bodies of {', '.join(bodies)} stay where they are"
            self._tell(rules.BEHAVIOUR, self._span(made), message)

    def _told_entries(self, place: ast.expr, values: dict[str, str]) -> None:
        for key in values:
            parts = key.split(".")
            if key in _KNOWN or (
                parts[0] == "conf"
                and len(parts) > 2
                and parts[1] in ("default", *_PROPERTIES)
            ):
                continue
            self._tell(rules.NOT_CARRIED, self._span(place), f"{key} is left out")

    # Parameters.

    def _parameters(
        self, place: ast.expr, values: dict[str, str]
    ) -> Iterator[ProfileParameter]:
        bound = dict(self._bound())
        names = [
            key.removeprefix("conf.default.")
            for key in values
            if key.startswith("conf.default.")
        ]
        for name in dict.fromkeys((*names, *bound)):
            node, to, default = bound.get(name, (place, "", ""))
            span = self._span(node)
            told = values.get(f"conf.default.{name}", default)
            word = values.get(f"conf.__type__.{name}") or self._word(to)
            constraint = None
            try:
                constraint = parse(values.get(f"conf.__constraints__.{name}", ""))
            except ConstraintError as error:
                message = f"the constraint of {name} is left out: {error}"
                self._tell(rules.NOT_CARRIED, span, message)
            yield ProfileParameter(
                name=name,
                type=word,
                default=told,
                span=span,
                type_span=span,
                default_span=span,
                variable=self._identifier(to),
                widget=values.get(f"conf.__widget__.{name}", ""),
                constraint=constraint,
            )

    def _identifier(self, told: str) -> str:
        name = told.removeprefix("self.")
        if self.generated:
            return name.removeprefix(GENERATED_VARIABLE)
        return name.lstrip("_")

    def _bound(self) -> Iterator[tuple[str, tuple[ast.expr, str, str]]]:
        for call in self._body.calls:
            if not _is(call, "bindParameter"):
                continue
            name = text(argument(call, 0, "param_name"))
            if name is None:
                message = "the name of a parameter is computed"
                self._tell(rules.COMPUTED, self._span(call), message)
                continue
            bound = variable(argument(call, 1, "var"))
            default = text(argument(call, 2, "def_val"))
            yield name, (call, bound or "", default or "")

    def _word(self, bound: str) -> str:
        """The type of a variable that a parameter is bound to, by its first value."""
        match self._body.values.get(bound):
            case ast.List(elts=[first]):
                match first:
                    case ast.Constant(value=value):
                        return _WORDS.get(type(value), "string")
                    case ast.UnaryOp(operand=ast.Constant(value=value)):
                        return _WORDS.get(type(value), "string")
                    case ast.List(elts=[ast.Constant(value=value), *_]):
                        return f"std::vector<{_WORDS.get(type(value), 'string')}>"
        return "string"

    # Ports.

    def _data_ports(self) -> Iterator[ProfileDataPort]:
        adding = [call for call in self._body.calls if _is(call, *_ADD_DATA_PORT)]
        added = [argument(call, 1, "inport", "outport") for call in adding]
        names = {variable(port) for port in added}
        made = [(name, call) for name, call in self._body.values.items()]
        made += [("", port) for port in added if isinstance(port, ast.Call)]
        for holder, value in made:
            if not isinstance(value, ast.Call) or not _is(value, *_DATA_PORTS):
                continue
            span = self._span(value)
            name = text(argument(value, 0, "name"))
            if name is None:
                which = f" {holder.removeprefix('self.')}" if holder else ""
                message = f"the name of the port{which} is computed"
                self._tell(rules.COMPUTED, span, message)
                continue
            if holder and holder not in names:
                self._tell(rules.NOT_ADDED, span, f"the port {name} is left out")
                continue
            type_ = self._data_type(argument(value, 1, "value"))
            if type_ is None:
                message = f"the type of the port {name} is computed"
                self._tell(rules.COMPUTED, span, message)
                type_ = "Unknown"
            yield ProfileDataPort(
                name=name,
                output=_is(value, "OutPort"),
                type=type_,
                span=span,
                type_span=span,
            )
        self._other_ports(adding, added)

    def _other_ports(
        self, adding: Sequence[ast.Call], added: Sequence[ast.expr | None]
    ) -> None:
        """Ports that are added, but made in no way that is understood."""
        for call, port in zip(adding, added, strict=True):
            made = self._body.values.get(variable(port) or "", port)
            if not _is(made, *_DATA_PORTS):
                name = text(call.args[0]) if call.args else None
                message = f"the port {name or ''} is computed"
                self._tell(rules.COMPUTED, self._span(call), message)

    def _data_type(self, datum: ast.expr | None) -> str | None:
        name = variable(datum)
        if name in self._body.types:
            return self._imports.scoped(dotted(self._body.types[name]))
        value = self._body.values.get(name) if name is not None else datum
        if not isinstance(value, ast.Call):
            return None
        if _is(value, "instantiateDataType") and value.args:
            return self._imports.scoped(dotted(value.args[0]))
        return self._imports.scoped(called(value))

    def _service_ports(self) -> Iterator[ProfileServicePort]:
        added = {
            variable(argument(call, 0, "port"))
            for call in self._body.calls
            if _is(call, *_ADD_SERVICE_PORT)
        }
        for holder, value in self._body.values.items():
            if not _is(value, "CorbaPort"):
                continue
            assert isinstance(value, ast.Call)
            name = text(argument(value, 0, "name"))
            if name is None:
                shown = holder.removeprefix("self.")
                message = f"the name of the service port {shown} is computed"
                self._tell(rules.COMPUTED, self._span(value), message)
            elif holder not in added:
                span = self._span(value)
                self._tell(rules.NOT_ADDED, span, f"the port {name} is left out")
            else:
                interfaces = tuple(self._interfaces(holder))
                yield ProfileServicePort(name=name, interfaces=interfaces)

    def _interfaces(self, port: str) -> Iterator[ProfileInterface]:
        kinds = {"registerProvider": True, "registerConsumer": False}
        for call in self._body.calls:
            names = called(call)
            if ".".join(names[:-1]) != port or names[-1] not in kinds:
                continue
            span = self._span(call)
            instance, type_ = (
                text(argument) for argument in [*call.args[:2], None][:2]
            )
            if instance is None or type_ is None:
                shown = port.removeprefix("self.")
                message = f"an interface of the port {shown} is computed"
                self._tell(rules.COMPUTED, span, message)
                continue
            provided = kinds[names[-1]]
            if not provided and len(call.args) > 2:
                type_ = self._consumed(call.args[2]) or type_
            yield ProfileInterface(
                name=instance,
                provided=provided,
                type=type_,
                span=span,
                type_span=span,
            )

    def _consumed(self, consumer: ast.expr) -> str | None:
        """The interface of a `CorbaConsumer`, whose registration may leave out its module."""
        name = variable(consumer)
        value = self._body.values.get(name) if name is not None else consumer
        if not _is(value, "CorbaConsumer"):
            return None
        assert isinstance(value, ast.Call)
        arguments = [k.value for k in value.keywords if k.arg == "interfaceType"]
        arguments += value.args
        return self._imports.scoped(dotted(arguments[0])) if arguments else None


def _is(node: ast.expr | None, *names: str) -> bool:
    """Whether it is a call of one of these, wherever they are imported from."""
    return called(node)[-1:] in {(name,) for name in names}


def _is_empty(function: ast.FunctionDef) -> bool:
    """Whether a callback does nothing but to return a code."""
    rest = [
        node
        for node in function.body
        if not isinstance(node, ast.Pass | ast.Return)
        and not (isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant))
    ]
    return not rest


def _own_text(docstring: str | None) -> str:
    """The class's docstring, without the lines of RTCBuilder's template."""
    lines = (line.strip() for line in (docstring or "").split("\n"))
    kept = [
        line for line in lines if not line.startswith(("\\brief", "@class", "@brief"))
    ]
    return "\n".join(kept).strip()


def _positive(word: str) -> float | None:
    try:
        rate = float(word)
    except ValueError:
        return None
    return rate if 0.0 < rate < 1e9 else None


def _count(word: str) -> int:
    return int(word) if word.isascii() and word.isdigit() and len(word) < 10 else 1
