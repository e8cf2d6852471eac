"""What became of a component that a behaviour was written for, and no definition has any more."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

import msgspec

from rtgen.compiler.matching import matching

_DECLARED = re.compile(r"^    (\w+) = (\w+)\(([\w.]*)", re.M)
_PARAMETER = re.compile(r"^    (\w+): ([\w.\[\], ]+) = parameter\(", re.M)
_BASE = re.compile(r"^class (\w+)Base\(", re.M)
_TYPE = re.compile(r'^    type_name="(\w+)",$', re.M)
_USE = re.compile(r"\bself\.(?:config\.)?(\w+)")
_OWN = re.compile(r"\bself\.(\w+)\s*(?:[,:]|=(?!=))|^ +(?:def )?(\w+) *[:(=]", re.M)


class Orphan(msgspec.Struct, frozen=True):
    """A behaviour without its component.

    `module` is the one that it imports its base from, `text` its own, `base` that of the generated
    module, if that is still there.
    """

    module: str
    text: str
    base: str = ""

    @property
    def name(self) -> str:
        """The name that the component had."""
        match = re.search(
            rf"\.{self.module}(?:\.\w+)? import \(?\s*(\w+?)Base\b", self.text
        )
        return type_name(self.base) or (match[1] if match else self.module)


def type_name(base: str) -> str:
    """Return the name of a component from its generated module; empty without a component."""
    match = _TYPE.search(base) or _BASE.search(base)
    return match[1] if match else ""


def declared(base: str) -> frozenset[tuple[str, str, str]]:
    """Return the ports and parameters in a generated module, with their kinds and types."""
    found = {(m[1], m[2], m[3]) for m in _DECLARED.finditer(base) if m[1] != "config"}
    return frozenset(
        found | {(m[1], "parameter", m[2]) for m in _PARAMETER.finditer(base)}
    )


def became(
    orphans: Sequence[Orphan], newcomers: Mapping[str, str]
) -> dict[str, tuple[str, ...]]:
    """Return the modules that each orphan's component may have now, the likeliest first.

    `newcomers` are the generated modules of components without a behaviour. The only one with the
    same ports and parameters is the component; without those of before, each one that has what the
    behaviour uses may be.
    """
    found = matching(
        {orphan.module: orphan for orphan in orphans},
        {module: Orphan(module, "", text) for module, text in newcomers.items()},
        lambda item: declared(item.base) or None,
    )
    sure = {one.module: other.module for one, other in found.renamed}
    left = {m: text for m, text in newcomers.items() if m not in sure.values()}
    return {
        orphan.module: (
            (sure[orphan.module],) if orphan.module in sure else _possible(orphan, left)
        )
        for orphan in orphans
    }


def _possible(orphan: Orphan, newcomers: Mapping[str, str]) -> tuple[str, ...]:
    # imported lazily, for reports only
    from rtgen.compiler.frontends.kit.suggestions import nearest

    own = {name for match in _OWN.finditer(orphan.text) for name in match.groups()}
    used = {match[1] for match in _USE.finditer(orphan.text)} - own - {"config"}
    names = {m: {name for name, _, _ in declared(t)} for m, t in newcomers.items()}
    shared = {module: len(used & names[module]) for module in newcomers}
    most = max(shared.values(), default=0)
    fitting = sorted(module for module, number in shared.items() if number == most)
    if most == 0 and used and len(fitting) > 1:
        near = nearest(orphan.module, fitting)
        return (near,) if near else ()
    if near := nearest(orphan.module, fitting):
        return (near, *(module for module in fitting if module != near))
    return tuple(fitting)
