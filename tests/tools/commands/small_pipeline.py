"""A minimal front end and back end, for tests of the code around them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from hashlib import sha256

from rtgen.compiler.backends import Artifact, Backend, Emission, Options
from rtgen.compiler.diagnostics import Diagnostic, Severity, Span
from rtgen.compiler.frontends import Dependency, FrontendResult
from rtgen.compiler.frontends.kit.memo import Memo
from rtgen.compiler.model import Model, SourceFile
from rtgen.compiler.project import Project


@dataclass
class SmallBackend:
    """Emits one file for each input, which holds the input's hash."""

    name: str = "small"

    def emit(self, model: Model, options: Options) -> Emission:
        return Emission(
            [
                Artifact(f"{options.package}/{f.key}.txt", f"{f.sha256}\n", (f.key,))
                for f in model.files
            ]
        )


@dataclass
class Pipeline:
    """Counts the readings of definitions; `warn` adds a warning to each input."""

    reads: int = 0
    warn: bool = False
    backends: list[Backend] = field(default_factory=lambda: [SmallBackend()])

    def read(
        self,
        project: Project,
        *,
        lowered: bool = False,
        also: Sequence[FrontendResult] = (),
        memo: Memo | None = None,
    ) -> FrontendResult:
        self.reads += 1
        files: list[SourceFile] = []
        found: list[Diagnostic] = []
        dependencies = [Dependency(p / "missing.idl", None) for p in project.include]
        sources: dict[str, str] = {}
        for path in project.sources:
            data = path.read_bytes()
            name, digest = path.as_posix(), sha256(data).hexdigest()
            files.append(SourceFile(name=name, key=path.name, sha256=digest, main=True))
            dependencies.append(Dependency(path, digest))
            sources[name] = data.decode()
            span = Span(name, 1, 1, 1, 2)
            if b"error" in data:
                found.append(Diagnostic("IDL0999", Severity.ERROR, "an error", span))
            if self.warn:
                found.append(
                    Diagnostic("IDL0998", Severity.WARNING, "a warning", span, (), "so")
                )
        return FrontendResult(
            Model(tuple(files)), tuple(found), sources, tuple(dependencies)
        )

    def emitting(self) -> Sequence[Backend]:
        return self.backends
