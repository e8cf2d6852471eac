"""The component that a module of OpenRTM-aist-Python makes, as far as it is written out."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Sequence

from rtgen.diagnostics import Diagnostic, Rule, Span
from rtgen.facts.constraints import ConstraintError, parse
from rtgen.frontends.openrtm_python import rules
from rtgen.frontends.openrtm_python.modules import Modules
from rtgen.frontends.openrtm_python.outline import (
    Item,
    component_classes,
    module_spec,
    unknown_bases,
)
from rtgen.frontends.openrtm_python.ports import ADD_DATA_PORT, ADD_SERVICE_PORT, Ports
from rtgen.frontends.openrtm_python.values import (
    GENERATED,
    GENERATED_VARIABLE,
    UNKNOWN,
    Class,
    Component,
    Module,
    Value,
    dotted,
)
from rtgen.frontends.openrtm_python.walker import (
    MOST_STEPS,
    Call,
    TooMuchError,
    Walker,
)
from rtgen.frontends.rtc_profile.names import ACTIVITY_TYPES, COMPONENT_TYPES
from rtgen.model.rtc_profile import ProfileParameter, RtcProfile

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
_WORDS = {bool: "bool", int: "int", float: "double", str: "string"}
_DATE = "1970-01-01T00:00:00+00:00"


class ModuleReader:
    """Reads one module; what could not be carried over is in `diagnostics`."""

    def __init__(self, module: Module, modules: Modules) -> None:
        self.diagnostics: list[Diagnostic] = []
        self._module = module
        self._file = module.source.file
        self._walker = Walker(modules)

    @property
    def generated(self) -> bool:
        """Whether it is a module that rtgen makes."""
        start = ".".join(GENERATED)
        return any(
            (node.module or "").startswith(start)
            for node in ast.walk(self._module.tree)
            if isinstance(node, ast.ImportFrom)
        )

    def profile(self) -> RtcProfile | None:
        """The component, None if there is none."""
        try:
            self._walker.module(self._module)
            spec = module_spec(self._module, self._walker)
            classes = component_classes(self._module, self._walker)
        except (TooMuchError, RecursionError):
            start = Span(self._file, 1, 1, 1, 2)
            message = f"the module does more than {MOST_STEPS:,} steps before its class"
            self._tell(rules.NO_COMPONENT, start, message)
            return None
        if spec is None or not classes:
            self._told_nothing(spec is None)
            return None
        place, items = spec
        made = classes[0]
        component = Component(classes)
        self._walk(component)
        for each in reversed(classes):
            self._told_callbacks(each)
        values = dict(self._pairs(items))
        self._told_entries(place, values)
        kind = values.get("activity_type", "")
        ports = Ports(self._walker, self._module, component, self._tell)
        return RtcProfile(
            file=self._file,
            span=self._span(made.node),
            format_version="0.3",
            name=values.get("implementation_id") or made.node.name,
            vendor=values.get("vendor", ""),
            category=values.get("category", ""),
            version=values.get("version") or "1.0.0",
            description=values.get("description", ""),
            doc=_own_text(ast.get_docstring(made.node)),
            component_type=kind if kind in COMPONENT_TYPES else "STATIC",
            activity=kind if kind in ACTIVITY_TYPES else "PERIODIC",
            kind="DataFlowComponent",
            execution=values.get("exec_cxt.periodic.type", "PeriodicExecutionContext"),
            rate=_positive(values.get("exec_cxt.periodic.rate", "")),
            max_instances=_count(values.get("max_instance", "")),
            created=_DATE,
            updated=_DATE,
            parameters=tuple(self._parameters(place, values)),
            data_ports=tuple(ports.data_ports()),
            service_ports=tuple(ports.service_ports()),
        )

    def _tell(
        self, rule: Rule, span: Span, message: str, hint: str | None = None
    ) -> None:
        self.diagnostics.append(rule.at(span, message, hint=hint))

    def _span(self, node: ast.AST, file: str = "") -> Span:
        return span_of(node, file or self._file)

    def _told_nothing(self, no_spec: bool) -> None:
        start = Span(self._file, 1, 1, 1, 2)
        what = "module spec" if no_spec else f"class that derives from {_BASE}"
        hint = None
        if not no_spec:
            for base, name in unknown_bases(self._module, self._walker):
                start = self._span(base)
                what += f", and {name} is not found"
                hint = "name the folder of its module with -I"
                break
        self._tell(rules.NO_COMPONENT, start, f"there is no {what}", hint)

    # What is done when the component is made.

    def _walk(self, component: Component) -> None:
        """Follows the constructor and onInitialize, then what else adds ports."""
        try:
            for name in ("__init__", "onInitialize"):
                self._walker.method(component, name)
            for each in component.line:
                for node in each.node.body:
                    if not isinstance(node, ast.FunctionDef) or not _adds(node):
                        continue
                    function = component.method(node.name)
                    later = node not in self._walker.walked
                    if later and function is not None and function.node is node:
                        self._walker.perhaps(function, component)
        except (TooMuchError, RecursionError):
            place = component.line[0]
            message = f"more than {MOST_STEPS:,} steps are needed; the rest is left out"
            self._tell(
                rules.COMPUTED,
                self._span(place.node, place.module.source.file),
                message,
            )

    # The module spec and the class.

    def _pairs(self, items: Sequence[Item]) -> Iterator[tuple[str, str]]:
        for (_, name), (node, told) in zip(items[::2], items[1::2], strict=False):
            if not isinstance(name, str) or not isinstance(told, str):
                shown = name if isinstance(name, str) else ""
                message = f"the entry {shown} of the module spec is computed"
                self._tell(rules.COMPUTED, self._span(node), message)
            else:
                yield name, told

    def _told_callbacks(self, made: Class) -> None:
        bodies = [
            node.name
            for node in made.node.body
            if isinstance(node, ast.FunctionDef)
            and node.name in _CALLBACKS
            and not _is_empty(node)
        ]
        if bodies:
            message = f"the bodies of {', '.join(bodies)} stay where they are"
            span = self._span(made.node, made.module.source.file)
            self._tell(rules.BEHAVIOUR, span, message)

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
            call = bound.get(name)
            span = self._span(place) if call is None else self._place(call)
            word = values.get(f"conf.__type__.{name}")
            if word is None:
                word = self._word(name, call, span)
            default = values.get(f"conf.default.{name}")
            if default is None:
                default = self._default(name, call, span)
            constraint = None
            try:
                constraint = parse(values.get(f"conf.__constraints__.{name}", ""))
            except ConstraintError as error:
                message = f"the constraint of {name} is left out: {error}"
                self._tell(rules.NOT_CARRIED, span, message)
            yield ProfileParameter(
                name=name,
                type=word,
                default=default,
                span=span,
                type_span=span,
                default_span=span,
                variable="" if call is None else self._identifier(call),
                widget=values.get(f"conf.__widget__.{name}", ""),
                constraint=constraint,
            )

    def _place(self, call: Call) -> Span:
        return self._span(call.made.node, call.made.file)

    def _identifier(self, call: Call) -> str:
        arguments = call.made.node.args
        names = dotted(arguments[1]) if len(arguments) > 1 else ()
        if not names or (len(names) > 1 and (len(names) > 2 or names[0] != "self")):
            return ""
        name = names[-1]
        if self.generated:
            return name.removeprefix(GENERATED_VARIABLE)
        return name.lstrip("_")

    def _bound(self) -> Iterator[tuple[str, Call]]:
        for call in self._walker.calls:
            if call.name != "bindParameter":
                continue
            name = call.argument(0, "param_name")
            if not isinstance(name, str):
                message = "the name of a parameter is computed"
                self._tell(rules.COMPUTED, self._place(call), message)
                continue
            if not call.made.certain:
                message = f"whether there is a parameter {name} depends on the run"
                self._tell(rules.COMPUTED, self._place(call), message)
            yield name, call

    def _word(self, name: str, call: Call | None, span: Span) -> str:
        """The type of the variable that a parameter is bound to, by its first value."""
        first = UNKNOWN if call is None else call.argument(1, "var")
        if isinstance(first, list) and len(first) == 1:
            item = first[0]
            if type(item) in _WORDS:
                return _WORDS[type(item)]
            if isinstance(item, list | tuple) and item and type(item[0]) in _WORDS:
                return f"std::vector<{_WORDS[type(item[0])]}>"
        if call is not None:
            message = f"the type of the parameter {name} is computed; string is taken"
            self._tell(rules.COMPUTED, span, message)
        return "string"

    def _default(self, name: str, call: Call | None, span: Span) -> str:
        default: Value = UNKNOWN if call is None else call.argument(2, "def_val")
        if isinstance(default, str):
            return default
        message = f"the default of the parameter {name} is computed"
        self._tell(rules.COMPUTED, span, message)
        return ""


def span_of(node: ast.AST, file: str) -> Span:
    """Where a node stands; of a class, its name."""
    line = getattr(node, "lineno", 1)
    column = getattr(node, "col_offset", 0) + 1
    end = getattr(node, "end_lineno", line)
    end_column = getattr(node, "end_col_offset", column) + 1
    if isinstance(node, ast.ClassDef):
        end, end_column = line, column + len("class ") + len(node.name)
    return Span(file, line, column, end, end_column)


def _adds(function: ast.FunctionDef) -> bool:
    """Whether a method itself adds ports or parameters."""
    wanted = {*ADD_DATA_PORT, *ADD_SERVICE_PORT, "bindParameter"}
    return any(
        isinstance(node, ast.Attribute) and node.attr in wanted
        for node in ast.walk(function)
    )


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
