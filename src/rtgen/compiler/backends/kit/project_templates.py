"""Templates of a project, laid over those of rtgen and rendered in Jinja's sandbox.

A template of a project names the original that it replaces as `rtgen/NAME`, to extend or include
it.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from difflib import get_close_matches
from functools import cache
from pathlib import Path
from typing import Any

import msgspec
from jinja2 import (
    BaseLoader,
    Environment,
    FileSystemLoader,
    PrefixLoader,
    Template,
    TemplateNotFound,
    TemplateSyntaxError,
    nodes,
)
from jinja2.exceptions import SecurityError
from jinja2.runtime import LoopContext, Macro
from jinja2.sandbox import ImmutableSandboxedEnvironment

from rtgen.compiler.backends.kit import rendering
from rtgen.compiler.backends.kit.quoting.code import UnquotableError
from rtgen.compiler.backends.kit.rules import TEMPLATE_FAULT
from rtgen.compiler.diagnostics import Diagnostic, InputError, Span, has_errors
from rtgen.facts.files import UnreadableError, read_file

ORIGINALS = "rtgen"
"""The prefix of rtgen's own templates in those of a project."""

_MAX_BYTES = 1024 * 1024
_MAX_REPEATED = 100_000
"""Maximum number of items that `*` makes in a template."""

_REFERENCE = re.compile(r"""{%-?\s*(?:extends|include|import|from)\s+["']([^"']+)""")
_BLOCK = re.compile(r"{%-?\s*block\s+(\w+)")
_METHODS_OF = (str, dict, list, tuple, LoopContext)


class TemplateFile(msgspec.Struct, frozen=True):
    """A template of a project: its path as displayed, its text."""

    path: str
    text: str

    def fault(self, line: int, message: str, hint: str | None = None) -> Diagnostic:
        """Return the diagnostic for a fault in a line."""
        lines = self.text.splitlines() or [""]
        line = min(max(line, 1), len(lines))
        text = lines[line - 1]
        start = len(text) - len(text.lstrip()) + 1
        span = Span(self.path, line, start, line, max(len(text) + 1, start + 1))
        return TEMPLATE_FAULT.at(span, message, hint=hint)


class ProjectTemplates(msgspec.Struct, frozen=True):
    """The templates of a project by name, and the faults in them."""

    files: Mapping[str, TemplateFile]
    findings: tuple[Diagnostic, ...] = ()

    @property
    def failed(self) -> bool:
        """Whether there are faults."""
        return has_errors(self.findings)

    @property
    def sources(self) -> dict[str, str]:
        """The texts by displayed path."""
        return {file.path: file.text for file in self.files.values()}


def read(paths: Mapping[str, Path]) -> ProjectTemplates:
    """Return the templates at the paths by name; those with faults are reported."""
    files: dict[str, TemplateFile] = {}
    findings: list[Diagnostic] = []
    for name, path in paths.items():
        file = TemplateFile(path.as_posix(), "")
        try:
            text = read_file(path, _MAX_BYTES).decode("utf-8-sig")
            file = msgspec.structs.replace(file, text=text)
            tree = _Renderer({name: file}).environment(name).parse(text)
            findings += _faults_of_extension(name, file, tree)
        except (OSError, UnreadableError) as error:
            findings.append(file.fault(1, f"cannot be read: {error.strerror or error}"))
        except UnicodeDecodeError:
            findings.append(file.fault(1, "is not UTF-8"))
        except TemplateSyntaxError as error:
            findings.append(file.fault(error.lineno, str(error.message)))
        files[name] = file
    return ProjectTemplates(files, tuple(findings))


def _faults_of_extension(
    name: str, file: TemplateFile, tree: nodes.Template
) -> Iterator[Diagnostic]:
    """Yield what Jinja accepts in a template that extends another, and what has no effect."""
    references: list[nodes.Extends | nodes.Include] = [
        *tree.find_all(nodes.Extends),
        *tree.find_all(nodes.Include),
    ]
    for reference in references:
        target = reference.template
        if isinstance(target, nodes.Const) and target.value == name:
            hint = f"the original is {ORIGINALS}/{name}"
            yield file.fault(reference.lineno, "this is the template itself", hint)
    base = tree.find(nodes.Extends)
    if base is None or not isinstance(base.template, nodes.Const):
        return
    prefix, _, original = str(base.template.value).partition("/")
    if prefix != ORIGINALS or original not in rendering.template_names():
        return
    blocks = _BLOCK.findall(rendering.template_source(original))
    for each in tree.body:
        if isinstance(each, nodes.Block) and each.name not in blocks:
            close = get_close_matches(each.name, blocks, n=1)
            hint = f"did you mean {close[0]}?" if close else _listed(blocks)
            message = f"the original has no block {each.name!r}"
            yield file.fault(each.lineno, message, hint)


def _listed(blocks: Sequence[str]) -> str:
    return f"there are: {', '.join(blocks)}" if blocks else "it has no blocks"


@contextmanager
def laid_over(templates: ProjectTemplates) -> Iterator[None]:
    """Within the block, `rendering.render` prefers the templates of a project.

    It raises InputError for a fault in one of them.
    """
    token = rendering.RENDERER.set(_Renderer(templates.files).render)
    try:
        yield
    finally:
        rendering.RENDERER.reset(token)


class _Renderer:
    """Renders templates of which some are those of a project."""

    def __init__(self, files: Mapping[str, TemplateFile]) -> None:
        self._files = files
        self._by_path = {file.path: file for file in files.values()}
        self._environments: dict[str, Environment] = {}
        self._templates: dict[str, Template] = {}

    def render(self, name: str, values: Mapping[str, Any]) -> str:
        """See `rendering.render`."""
        blamed = self._changed_by(name)
        if blamed is None:
            return rendering.render_original(name, values)
        try:
            if name not in self._templates:
                self._templates[name] = self.environment(name).get_template(name)
            text = self._templates[name].render(values)
        except Exception as error:  # whatever an expression of a project raises
            raise self._located(error) from error
        if name.endswith(".py.j2"):
            _require_python(self._files[blamed], text)
        return rendering.language_of(name).code(text)

    def environment(self, name: str) -> Environment:
        """Return the environment of a template."""
        suffix = rendering.suffix_of(name)
        if suffix not in self._environments:
            self._environments[suffix] = rendering.configured(
                _Sandbox, suffix, _Loader(self._files)
            )
        return self._environments[suffix]

    def _changed_by(self, name: str) -> str | None:
        """Return the project's template that a template is, or refers to."""
        if name in self._files:
            return name
        changes = map(self._changed_by, _references(name))
        return next(filter(None, changes), None)

    def _located(self, error: Exception) -> Exception:
        """Return the diagnostic of an error in a template of the project, else the error."""
        if isinstance(error, TemplateSyntaxError):
            file = self._by_path.get(error.filename or "")
            if file is not None:
                return InputError([file.fault(error.lineno, str(error.message))])
        traceback, place = error.__traceback__, None
        while traceback is not None:
            file = self._by_path.get(traceback.tb_frame.f_code.co_filename)
            place = (file, traceback.tb_lineno) if file is not None else place
            traceback = traceback.tb_next
        if place is None:
            return error
        file, line = place
        hint = None
        if isinstance(error, UnquotableError):
            hint = "a filter quotes a text: literal, comment, in_docstring"
        elif isinstance(error, TemplateNotFound):
            hint = f"rtgen's templates are {ORIGINALS}/NAME"
        return InputError([file.fault(line, _reason(error), hint)])


def _reason(error: Exception) -> str:
    if isinstance(error, TemplateNotFound):
        return f"there is no template {error.name!r}"
    return str(error).strip() or type(error).__name__


def _require_python(file: TemplateFile, text: str) -> None:
    """Raise InputError for a text that is no Python."""
    try:
        ast.parse(text)
    except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
        reason = error.msg if isinstance(error, SyntaxError) else str(error)
        line = (error.text or "").strip() if isinstance(error, SyntaxError) else ""
        message = f"the text that it renders is not Python: {reason}"
        if line:
            message += f" in {line!r}"
        raise InputError([file.fault(1, message)]) from None


@cache
def _references(name: str) -> tuple[str, ...]:
    """Return the templates that one of rtgen's names."""
    return tuple(_REFERENCE.findall(rendering.template_source(name)))


class _Loader(BaseLoader):
    """Loads templates of the project, which are compiled in each run, then those of rtgen."""

    def __init__(self, files: Mapping[str, TemplateFile]) -> None:
        self._files = files
        of_rtgen = FileSystemLoader(rendering.FOLDER)
        self._others = (of_rtgen, PrefixLoader({ORIGINALS: of_rtgen}))

    def load(
        self,
        environment: Environment,
        name: str,
        globals: Any = None,  # noqa: A002 - the name in Jinja
    ) -> Template:
        """See `BaseLoader`."""
        if (file := self._files.get(name)) is not None:
            code = environment.compile(file.text, name, file.path)
            return environment.template_class.from_code(
                environment, code, globals or {}
            )
        prefixed = name.startswith(f"{ORIGINALS}/")
        return self._others[prefixed].load(environment, name, globals)


class _Sandbox(ImmutableSandboxedEnvironment):
    """Renders without access to anything beyond the values given and their attributes.

    Calls are those of macros, and of methods of texts and collections.
    """

    intercepted_binops = frozenset({"*", "**", "%"})

    def is_safe_callable(self, obj: Any) -> bool:
        """See `SandboxedEnvironment`."""
        if isinstance(obj, Macro | LoopContext):
            return True
        owner = getattr(obj, "__self__", None)
        return isinstance(owner, _METHODS_OF) and super().is_safe_callable(obj)

    def call_binop(self, context: Any, operator: str, left: Any, right: Any) -> Any:
        """See `SandboxedEnvironment`. Raises SecurityError for results of any size."""
        numbers = isinstance(left, int | float) and isinstance(right, int | float)
        if operator == "*" and not numbers:
            sizes = (
                each if isinstance(each, int) else len(each) for each in (left, right)
            )
            first, second = sizes
            if first * second > _MAX_REPEATED:
                raise SecurityError("a text or list of this size is not rendered")
        elif operator == "**" or not numbers:
            raise SecurityError(f"{operator!r} of these values is not rendered")
        return super().call_binop(context, operator, left, right)
