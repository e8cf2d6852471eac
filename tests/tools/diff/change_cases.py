"""The table of changes: one case for each form of a kind, in `cases/*.toml`.

A case has definitions of an old and a new version (`old` and `new`: a text, texts by file, or
replacements in the files of `cases/base` that the table names), files of both (`both`), the code,
the classes of breaks, and the codes of accompanying changes (`also`).
"""

from __future__ import annotations

import re
import textwrap
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field
from difflib import unified_diff
from functools import cache
from pathlib import Path

from rtgen.tools.diff.changes import Change
from rtgen.tools.diff.compare import compare
from rtgen.tools.diff.kinds.catalogue import KINDS
from rtgen.tools.diff.reading import Source, opened

FOLDER = Path(__file__).parent / "cases"
TITLES = {kind.code: kind.title for kind in KINDS}
_LANGUAGES = {
    ".idl": "idl",
    ".cdl": "cdl",
    ".toml": "toml",
    ".eds": "ini",
    ".dcf": "ini",
    ".xml": "xml",
}


@dataclass(frozen=True)
class Case:
    """A row of the table."""

    code: str
    form: str
    breaks: str
    old: Mapping[str, str]
    new: Mapping[str, str]
    both: Mapping[str, str] = field(default_factory=dict)
    also: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        """The code with the form."""
        return f"{self.code} {self.form}"

    def changes(self, folder: Path) -> list[Change]:
        """Return the changes between the two versions, which are written below `folder`."""
        sources = []
        for label, files in (("old", self.old), ("new", self.new)):
            below = folder / label
            for name, text in {**self.both, **files}.items():
                path = below / name
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_text(text, encoding="utf-8")
            sources.append(Source(label, below))
        with ExitStack() as stack:
            old, new = (stack.enter_context(opened(each)) for each in sources)
            return compare(old, new)


@cache
def cases() -> list[Case]:
    """Return all cases, by code."""
    found = []
    for path in sorted(FOLDER.glob("*.toml")):
        content = tomllib.loads(path.read_text(encoding="utf-8"))
        file = content.get("file", "")
        for each in content["case"]:
            texts = {
                key: _texts(each.get(key, {}), file, content.get("base", ()))
                for key in ("old", "new", "both")
            }
            found.append(
                Case(
                    each["code"],
                    each["form"],
                    each["breaks"],
                    texts["old"],
                    texts["new"],
                    texts["both"],
                    tuple(each.get("also", ())),
                )
            )
    return sorted(found, key=lambda case: case.code)


def _texts(
    value: str | dict[str, str] | list[tuple[str, str]],
    file: str,
    base: Sequence[str],
) -> dict[str, str]:
    if isinstance(value, list):
        texts = {name: (FOLDER / "base" / name).read_text("utf-8") for name in base}
        for before, after in value:
            [name] = [name for name, text in texts.items() if before in text]
            texts[name] = texts[name].replace(before, after)
        return texts
    texts = {file: value} if isinstance(value, str) else value
    return {name: _text(text) for name, text in texts.items()}


def _text(text: str) -> str:
    """Return a text, or that of the file in `base` whose name is given in <>."""
    if name := re.fullmatch(r"<([\w.]+)>", text):
        return (FOLDER / "base" / name[1]).read_text("utf-8")
    return text.rstrip("\n") + "\n"


def table() -> str:
    """Return the table of docs/changes.md."""
    rows = [
        f"| {case.code} | {TITLES[case.code]} | {case.form.replace('|', chr(92) + '|')} | "
        f"{case.breaks} |"
        for case in cases()
    ]
    head = ["| code | change | form | breaks |", "|---|---|---|---|"]
    return "\n".join([*head, *rows]) + "\n"


def page(code: str) -> str:
    """Return the page of `rtgen explain` for a kind: reason, first case, breaks of all forms."""
    kind = next(k for k in KINDS if k.code == code)
    own = [case for case in cases() if case.code == code]
    lines = [*_wrapped(f"{kind.why[0].upper()}{kind.why[1:]}."), ""]
    lines += _example(own[0])
    lines += ["What it breaks:", ""]
    lines += [f"- {case.form}: {case.breaks}" for case in own]
    return "\n".join(lines) + "\n"


def _example(case: Case) -> Iterator[str]:
    """Yield both versions of short texts, the difference of long ones."""
    texts = [*case.old.values(), *case.new.values()]
    if max(text.count("\n") for text in texts) <= 20:
        for label, files in (("before", case.old), ("after", case.new)):
            for name, text in files.items():
                language = _LANGUAGES.get(Path(name).suffix, "text")
                yield from (f"{label.capitalize()}, in `{name}`:", "", f"```{language}")
                yield from (*text.rstrip("\n").split("\n"), "```", "")
        return
    yield "```diff"
    for name in sorted({*case.old, *case.new}):
        old, new = (v.get(name, "").splitlines() for v in (case.old, case.new))
        if not (old and new):
            yield f"Only {'after' if new else 'before'}: {name}"
            continue
        hunks = unified_diff(old, new, name, name, lineterm="", n=1)
        yield from (line[:98] for line in hunks)
    yield from ("```", "")


def _wrapped(text: str) -> list[str]:
    return textwrap.wrap(text, 98)
