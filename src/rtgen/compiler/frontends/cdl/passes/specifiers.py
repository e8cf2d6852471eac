"""Specifier lists: the specifiers that each construct accepts."""

from __future__ import annotations

from collections.abc import Collection

from rtgen.compiler.diagnostics import Related
from rtgen.compiler.frontends.cdl.names.entities import Place, Report
from rtgen.compiler.frontends.cdl.rules import celltypes as rules
from rtgen.compiler.frontends.cdl.rules import syntax
from rtgen.compiler.frontends.cdl.syntax import tree

CELLTYPE = ("singleton", "active", "idx_is_id", "generate")
PORT = ("inline", "allocator", "optional", "omit", "dynamic", "ref_desc")
OUTER_PORT = ("allocator", "optional", "omit", "dynamic", "ref_desc")
ATTRIBUTE = ("omit", "size_is", "choice")
VARIABLE = ("size_is",)
CELL = ("allocator", "id", "prototype", "restrict", "generate")
INNER_CELL = ("allocator",)
JOIN = ("through",)
REGION = (
    *("linkunit", "node", "class", "domain"),
    *("in_through", "out_through", "to_through"),
)


_OWNERS = {
    "a signature": ("context", "callback", "deviate"),
    "a function": ("oneway",),
    "a parameter": ("in", "out", "inout", "send", "receive", "nullable"),
    "a parameter or struct member": ("count_is", "string"),
    "a parameter, struct member, attribute or variable": ("size_is",),
    "a celltype or composite": ("singleton", "active", "idx_is_id"),
    "a signature, celltype, composite or cell": ("generate",),
    "a call port": ("optional", "dynamic", "ref_desc"),
    "a call port or attribute": ("omit",),
    "an entry port": ("inline",),
    "an entry port or cell": ("allocator",),
    "an attribute": ("choice",),
    "a cell": ("id", "prototype", "restrict"),
    "a join in a cell": JOIN,
    "a region": REGION,
}
_OWNER = {word: owner for owner, words in _OWNERS.items() for word in words}


def belongs(word: str) -> str:
    """Return a hint that says what a specifier precedes."""
    example = ': [through( RTCPlugin, "" )] cCall = Cell.eEntry;' * (word == "through")
    return f"{word} belongs in front of {_OWNER[word]}{example}"


def accepted(
    bracket: tree.Specifiers | None,
    words: Collection[str],
    what: str,
    place: Place,
    report: Report,
) -> list[tree.Specifier]:
    """Return the specifiers that `what` accepts; reports the others."""
    found = []
    for specifier in bracket.items if bracket is not None else ():
        if specifier.word in words:
            found.append(specifier)
        else:
            hint = belongs(specifier.word)
            if words:
                hint = f"possible here are {', '.join(words)}; {hint}"
            report(
                syntax.MISPLACED_SPECIFIER.at(
                    place.span(specifier),
                    f"{specifier.word} cannot precede {what}",
                    hint=hint,
                )
            )
    return found


def once(
    specifiers: list[tree.Specifier], word: str, place: Place, report: Report
) -> tree.Specifier | None:
    """Return the only specifier with that keyword; reports a second one."""
    found = [s for s in specifiers if s.word == word]
    for other in found[1:]:
        report(
            rules.SPECIFIER_TWICE.at(
                place.span(other),
                f"{word} is given twice",
                related=[Related(place.span(found[0]), "the first time")],
                hint="remove one",
            )
        )
    return found[0] if found else None
