"""Hostile definitions: their texts are data in every output, or a diagnostic refuses them."""

from __future__ import annotations

import shutil
from collections.abc import Iterator, Mapping
from contextlib import chdir
from pathlib import Path

from fuzzing import ViolationError
from hostile_conversions import CONVERSIONS, Made
from hostile_definitions import DEFINITIONS, MAKERS
from hostile_outputs import Content, compare, content
from hostile_texts import Texts

from rtgen.compiler.compilation import compile_project
from rtgen.compiler.diagnostics import Severity
from rtgen.compiler.diagnostics.report import report
from rtgen.compiler.project import load

COUNT = 8
"""Number of definition files of one project."""

_TARGETS = ("embedded", "openrtm", "small", "typescript")
_KINDS = tuple((language, target) for target in _TARGETS for language in MAKERS)
_OTHERS = tuple((conversion, "") for conversion in CONVERSIONS)
_PROJECT = """[sources]
paths = [%s]
[output]
package = "fuzzed"
skeletons = "src/fuzzednodes"
target = "TARGET"
[ros2]
interfaces = true
"""

Twins = Mapping[str, tuple[str, Content]]
"""Text and content of harmless files by their paths."""


class HostileTarget:
    """Each case is a project of one input language for one target."""

    kinds = _KINDS

    def __init__(self, folder: Path, count: int = COUNT) -> None:
        self._folder = folder
        self._count = count
        self._twins: dict[tuple[str, str], Twins] = {}

    def make(self, number: int) -> bytes:
        """Return the files of the case, for people."""
        self._made(number, Texts(number, hostile=True))
        files = sorted(p for p in self._folder.rglob("*") if p.is_file())
        parts = (b"=== %s\n%s\n" % (p.name.encode(), p.read_bytes()) for p in files)
        return b"".join(parts)

    def check(self, number: int, data: bytes) -> Iterator[str]:
        """Generate all output, and that of the harmless twin; the two differ in data only."""
        if number < 0:
            return
        texts = Texts(number, hostile=True)
        codes, made = self._made(number, texts)
        language, target = self._kind(number)
        yield f"{language} {target}".strip()
        yield from ["definitions"] * (DEFINITIONS[language] * self._count)
        yield from ["texts"] * texts.count
        yield from codes
        if not made:
            yield "refused"
            return
        twins = self._twin(number)
        if set(twins) != set(made):
            raise ViolationError(f"other files: {sorted(set(made) ^ set(twins))[:5]}")
        strings: set[str] = set()
        for path, text in made.items():
            plain, twin = twins[path]
            if text == plain:
                continue
            try:
                found = content(path, text)
                if found.shape != twin.shape:
                    # A comment that is a text in brackets is a unit.
                    twin = self._twin_with_units(number)[path]
                compare(path, found, twin)
            except (ValueError, SyntaxError) as error:
                raise ViolationError(f"{path}: {error}") from error
            strings.update(map(_words, found.strings))
        for text in texts.used:
            if _words(text) not in strings:
                raise ViolationError(f"{text!r} is in no file")
        yield "made"

    def _kind(self, number: int) -> tuple[str, str]:
        return self.kinds[number % len(self.kinds)]

    def _twin(self, number: int) -> Twins:
        kind = self._kind(number)
        if kind not in self._twins:
            codes, made = self._made(number, Texts(0, hostile=False))
            if not made:
                raise ViolationError(f"the twin is refused: {codes}")
            self._twins[kind] = {
                path: (text, content(path, text)) for path, text in made.items()
            }
        return self._twins[kind]

    def _twin_with_units(self, number: int) -> dict[str, Content]:
        texts = Texts(number, hostile=False, bracketed=True)
        _, made = self._made(number, texts)
        return {path: content(path, text) for path, text in made.items()}

    def _made(self, number: int, texts: Texts) -> Made:
        shutil.rmtree(self._folder / "case", ignore_errors=True)
        root = self._folder / "case"
        root.mkdir()
        return self._files(self._kind(number), texts, root)

    def _files(self, kind: tuple[str, str], texts: Texts, root: Path) -> Made:
        language, target = kind
        files = MAKERS[language](texts, self._count)
        for name, text in files.items():
            path = root / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(text.encode("utf-8", "surrogatepass"))
        folders = sorted({f'"{name.partition("/")[0]}"' for name in files})
        settings = files.get("rtgen.toml", _PROJECT % ", ".join(folders))
        (root / "rtgen.toml").write_text(settings.replace("TARGET", target))
        with chdir(root):
            run = compile_project(load())
        report(run.diagnostics, run.sources)
        codes = [d.code for d in run.diagnostics]
        for each in run.diagnostics:
            if each.span is None and each.severity is Severity.ERROR:
                raise ViolationError(f"no place: {each.code} {each.message}")
        return codes, {a.path: str(a.text) for a in run.artifacts}


class ConversionsTarget(HostileTarget):
    """The target of systems with their pictures, adopted modules, and the forms of a profile."""

    kinds = _OTHERS

    def _files(self, kind: tuple[str, str], texts: Texts, root: Path) -> Made:
        return CONVERSIONS[kind[0]](texts, root)


def _words(text: str) -> str:
    """Return the part of a text that every profile preserves: single blanks, none outside."""
    return " ".join(text.split())
