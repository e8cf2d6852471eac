"""Reads a main file with its imports: search path, include-once, missing files."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from rtgen.compiler.diagnostics import Diagnostic, Rule, Span
from rtgen.compiler.frontends.cdl.c_headers.file import HeaderFile
from rtgen.compiler.frontends.cdl.rules import files
from rtgen.compiler.frontends.cdl.rules import headers as header_rules
from rtgen.compiler.frontends.cdl.syntax import parser, statements
from rtgen.compiler.frontends.cdl.syntax.unit import TypeNames, Unit
from rtgen.compiler.frontends.cdl.text.source import Source
from rtgen.compiler.frontends.cdl.text.tool_information import tool_information
from rtgen.compiler.frontends.kit.library import Library, absolute_path
from rtgen.compiler.model.tecs import TecsTypedef

if TYPE_CHECKING:
    from rtgen.compiler.frontends.cdl.c_headers.reader import Headers

MAX_DEPTH = 100
"""The largest depth of nested imports."""

_DEFINITION = re.compile(r"[A-Za-z_]\w*(?:=.*)?", re.DOTALL)
_KERNEL_FILES = re.compile(
    r"(?:\w*_)?(?:kernel|itron|tecs|t_stddef|t_syslog|syssvc|asp|hrp)\w*\.(?:cdl|h)"
)


class Reader:
    """Reads a main file and its imports, each file once."""

    def __init__(
        self,
        library: Library[Source],
        header_files: Library[HeaderFile],
        define: Mapping[str, str],
        prelude: frozenset[str],
        report: Callable[[Diagnostic], None],
    ) -> None:
        self.incomplete = False
        self.lacks_types = False
        self.units: list[Unit] = []
        self._library = library
        self._header_files = header_files
        self._definitions: dict[str, list[str]] = {}
        self._define = dict(define)
        self._folders = list(library.include)
        self._types = TypeNames(prelude)
        self._report = report
        self._read: dict[str, Unit] = {}
        self._missing: list[tuple[bool, Diagnostic, Diagnostic]] = []
        self._depth = 0

    def read(self, source: Source, *, reused: bool = False) -> Unit:
        """Parse a file and its imports."""
        unit = Unit(source, reused)
        self._read[absolute_path(source.path)] = unit
        for problem in source.problems:
            self._report(problem)
        imported = self._tool_imports(unit)
        parsed = parser.parse(unit, self._types, self, self._report)
        unit.items = (*imported, *parsed)
        self.units.append(unit)
        return unit

    def _tool_imports(self, unit: Unit) -> tuple[statements.Item, ...]:
        """Apply the `__tool_info__` of a file; return the imports in it."""
        information = tool_information(unit.source)
        if information is None:
            return ()
        self._folders += [Path(folder) for folder in information.folders]
        for macro in information.macros:
            name, equals, value = macro.partition("=")
            if _DEFINITION.fullmatch(macro):
                self._define.setdefault(name, value if equals else "1")
        imports = [
            statements.Import(information.start, information.end, name, False)
            for name in information.imports
        ]
        for statement in imports:
            self.import_file(statement, unit)
        return tuple(
            statements.Item(information.start, information.end, None, i)
            for i in imports
        )

    def import_file(self, statement: statements.Import, unit: Unit) -> None:
        span = unit.span(statement.start, statement.end)
        try:
            source = self._import_source(statement.path, unit)
        except (OSError, ValueError) as error:
            reason = getattr(error, "strerror", None) or error
            message = f"{statement.path} cannot be read: {reason}"
            self._report(files.UNREADABLE.at(span, message))
            return
        if source is None:
            self._report_missing(
                statement.path, span, files.IMPORT_MISSING, statement.reused
            )
            return
        cached = self._read.get(absolute_path(source.path))
        if cached is not None:
            if cached.reused is not statement.reused and cached.items:
                form = f"<{statement.path}>" if cached.reused else f'"{statement.path}"'
                message = f"the file was imported by import( {form} ) before"
                self._report(files.IMPORT_FORM.at(span, message))
            return
        if self._depth == MAX_DEPTH:
            message = f"files import files for more than {MAX_DEPTH} levels"
            self._report(files.IMPORT_DEPTH.at(span, message))
            return
        self._depth += 1
        unit.imports[statement] = self.read(
            source, reused=statement.reused or unit.reused
        )
        self._depth -= 1

    def import_header(self, statement: statements.ImportC, unit: Unit) -> None:
        span = unit.span(statement.start, statement.end)
        name = statement.header.text
        text = statement.definitions.text if statement.definitions else ""
        definitions = [d.strip() for d in text.split(",") if d.strip()]
        wrong = next((d for d in definitions if not _DEFINITION.fullmatch(d)), None)
        if wrong is not None:
            message = f"'{wrong}' is not a definition of a macro"
            self._report(header_rules.HEADER_DEFINITION.at(span, message))
            return
        file = None
        try:
            for path, folder in self._candidates(name, unit):
                file = file or self._header_files.open(path, folder)
        except (OSError, ValueError) as error:
            reason = getattr(error, "strerror", None) or error
            message = f"{name} cannot be read: {reason}"
            self._report(files.UNREADABLE.at(span, message))
            return
        if file is None:
            self._report_missing(name, span, header_rules.MISSING_HEADER)
            return
        before = self._definitions.get(file.name)
        if before is not None:
            if before != definitions:
                message = f"{name} was imported with other definitions before"
                self._report(header_rules.HEADER_TWICE.at(span, message))
            return
        self._definitions[file.name] = definitions
        header = self._headers.read(file, definitions, span)
        self.lacks_types |= self._headers.lacking
        unit.headers[statement] = header
        for declaration in header.declarations:
            if isinstance(declaration, TecsTypedef):
                self._types.declare((), declaration.name[-1])

    @cached_property
    def _headers(self) -> Headers:
        """The reader of C headers, created lazily: pcpp and pycparser are slow to import."""
        from rtgen.compiler.frontends.cdl.c_headers.reader import Headers

        return Headers(self._header_files, self._define, self._report)

    def _import_source(self, name: str, unit: Unit) -> Source | None:
        for path, folder in self._candidates(name, unit):
            source = self._library.open(path, folder)
            if source is not None:
                return source
        return None

    def _candidates(self, name: str, unit: Unit) -> Iterator[tuple[Path, Path | None]]:
        """Yield the candidate paths of an import, in order."""
        yield Path(name), None
        for folder in self._folders:
            yield folder / name, folder
        yield unit.source.folder / name, None

    def _report_missing(
        self, name: str, span: Span, rule: Rule, reused: bool = False
    ) -> None:
        self.incomplete = self.lacks_types = True
        message = f"{name} is not found"
        hint = "name its folder by -I, or in [sources] include of rtgen.toml"
        self._missing.append(
            (
                reused or bool(_KERNEL_FILES.fullmatch(Path(name).name)),
                rule.at(span, message, hint=hint),
                files.KERNEL_MISSING.at(span, message, hint=hint),
            )
        )

    def report_missing(self, *, failed: bool) -> None:
        """Report missing imports; a kernel's file is an error only if there are other errors."""
        failed = failed or not all(kernel for kernel, _, _ in self._missing)
        for kernel, error, warning in self._missing:
            self._report(warning if kernel and not failed else error)
