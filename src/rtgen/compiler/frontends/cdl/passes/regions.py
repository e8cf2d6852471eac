"""Pass over regions: reads specifiers, adds permitted joins and the plug-ins on their paths."""

from __future__ import annotations

from collections.abc import Callable

import msgspec
from msgspec.structs import replace

from rtgen.compiler.diagnostics import Related, Span
from rtgen.compiler.frontends.cdl.names.entities import Place, Plugin, Report, here
from rtgen.compiler.frontends.cdl.names.scopes import Kind, Scope
from rtgen.compiler.frontends.cdl.passes import plugins, specifiers
from rtgen.compiler.frontends.cdl.rules import regions as rules
from rtgen.compiler.frontends.cdl.syntax import statements, tree
from rtgen.compiler.frontends.cdl.syntax.unit import Unit
from rtgen.compiler.frontends.kit.suggestions import nearest


class Permits(msgspec.Struct, eq=False):
    """The joins that the specifiers of a region permit.

    A list of plug-ins is None without the specifier: then no join may cross the boundary. `free`
    marks a domain or class, whose plug-in decides.
    """

    linkunit: bool = False
    node: bool = False
    free: bool = False
    inward: list[Plugin] | None = None
    outward: list[Plugin] | None = None
    toward: dict[str, list[Plugin]] = msgspec.field(default_factory=dict)
    entered: int = -1
    left: int = -1
    gone: dict[str, int] = msgspec.field(default_factory=dict)


class Regions:
    """The regions of a unit."""

    def __init__(
        self, root: Scope, report: Report, has_plugin: Callable[[Unit, str], bool]
    ) -> None:
        """Initialize with the function that returns whether the file of a plug-in exists."""
        self._report = report
        self._has_plugin = has_plugin
        self.applied = plugins.Applied()
        self._permits: dict[Scope, Permits] = {root: Permits(node=True)}

    def of(self, scope: Scope) -> Permits:
        """Return the joins that a region permits."""
        return self._permits.setdefault(scope, Permits())

    def open(
        self, item: statements.Item, node: statements.Region, place: Place
    ) -> Scope:
        """Return the scope of a region, created at its first appearance."""
        outer, name = place.scope, node.name.text
        span = place.span(node.name)
        given = specifiers.accepted(
            item.specifiers, specifiers.REGION, f"region {name}", place, self._report
        )
        known = outer.own(name)
        if isinstance(known, Scope) and known.kind is Kind.REGION:
            if given:
                self._report(
                    rules.SPECIFIERS_AGAIN.at(
                        place.unit.span(given[0].start, given[-1].end),
                        f"the region {name} has its specifiers where it appears first",
                        related=here(known, "first opened here"),
                        hint="put them there",
                    )
                )
            return known
        scope = Scope((*outer.name, name), outer, Kind.REGION, span)
        if known is not None:
            self._report(
                rules.NAME_OF_ANOTHER.at(
                    span,
                    f"{name} is a {known.kind} already",
                    related=here(known, "first declared here"),
                    hint="rename one",
                )
            )
        else:
            outer.scopes[name] = scope
        self._specify(self.of(scope), scope, given, place)
        return scope

    def _specify(
        self, permits: Permits, scope: Scope, given: list[tree.Specifier], place: Place
    ) -> None:
        kinds: dict[str, tree.Specifier] = {}
        for specifier in given:
            word, arguments = specifier.word, list(specifier.arguments)
            if word in ("linkunit", "node", "class", "domain"):
                group = "executable" if word in ("linkunit", "node") else "protection"
                self._once(kinds, group, specifier, place)
                permits.linkunit |= word == "linkunit"
                permits.node |= word == "node"
                if group == "protection":
                    permits.free = True
                    name = arguments[0]
                    assert isinstance(name, tree.Name)
                    self.apply(name, place, on_way=True)
                continue
            target = ""
            if word == "to_through":
                name, *arguments = arguments
                assert isinstance(name, tree.Name)
                target = name.text
            made = self._plugin(word, scope, tuple(arguments), place)
            if word == "in_through":
                permits.inward = [*(permits.inward or ()), *made]
            elif word == "out_through":
                permits.outward = [*(permits.outward or ()), *made]
            else:
                permits.toward.setdefault(target, []).extend(made)

    def _plugin(
        self,
        origin: str,
        scope: Scope,
        arguments: tuple[tree.SpecifierArgument, ...],
        place: Place,
    ) -> list[Plugin]:
        if not arguments:
            return []
        name, argument = arguments
        assert isinstance(name, tree.Name)
        assert isinstance(argument, tree.Text)
        self.apply(name, place, on_way=True)
        return [Plugin(name, argument, place, origin, scope)]

    def _once(
        self,
        kinds: dict[str, tree.Specifier],
        group: str,
        specifier: tree.Specifier,
        place: Place,
    ) -> None:
        first = kinds.setdefault(group, specifier)
        if first is not specifier:
            self._report(
                rules.KIND_TWICE.at(
                    place.span(specifier),
                    (
                        f"a region is one of {first.word} and {specifier.word}"
                        if first.word != specifier.word
                        else f"{first.word} is given twice"
                    ),
                    related=[Related(place.span(first), "the first one")],
                    hint="remove one",
                )
            )

    def apply(self, name: tree.Name, place: Place, *, on_way: bool) -> None:
        """Record a plug-in; warns unless it is rtgen's or tecsgen's."""
        if plugins.is_ours(name.text):
            return
        applied = self.applied
        (applied.on_ways if on_way else applied.generators).append(name.text)
        if plugins.is_known(name.text):
            return
        file = f"{plugins.class_name(name.text)}.rb"
        if self._has_plugin(place.unit, file):
            return
        near = plugins.nearest(name.text)
        rule = rules.MISSPELT_PLUGIN if near else rules.UNKNOWN_PLUGIN
        own = f"{file} is found in the folders of -I, as by tecsgen's option -L"
        self._report(
            rule.at(
                place.span(name),
                f"the plug-in {name.text} is not known",
                hint=f"did you mean {near}? Else {own}" if near else own,
            )
        )

    # Paths

    def link_unit(self, scope: Scope) -> Scope:
        """Return the region that begins the link unit of a region."""
        for around in scope.outwards():
            permits = self.of(around)
            if permits.linkunit or permits.node or around.parent is None:
                return around
        raise AssertionError("a scope has a root")

    def distance(self, start: Scope, end: Scope) -> int | None:
        """Return the number of region boundaries between two regions; None if one is impassable."""
        out, inn, split = _crossings(start, end)
        for scope in out:
            permits = self.of(scope)
            if not permits.free and permits.outward is None:
                return None
        if split is not None:
            permits = self.of(split[0])
            if not permits.free and split[1].name[-1] not in permits.toward:
                return None
        for scope in inn:
            permits = self.of(scope)
            if not permits.free and permits.inward is None:
                return None
        return len(out) + len(inn) + (split is not None)

    def way(self, start: Scope, end: Scope, what: str, span: Span) -> list[Plugin]:
        """Return the regions' plug-ins on a join's path; reports boundaries it may not cross."""
        out, inn, split = _crossings(start, end)
        found: list[Plugin] = []
        if split is not None:  # the path goes from sibling to sibling
            out, inn = out[:-1], inn[1:]
        for scope in out:
            permits = self.of(scope)
            permits.left += 1
            if not permits.free and permits.outward is None:
                hint = "put [out_through()] before the region"
                message = f"{what} goes out of region {scope.name[-1]}, which does not permit it"
                self._report(rules.GOING_OUT.at(span, message, hint=hint))
            found += [replace(p, count=permits.left) for p in permits.outward or ()]
        if split is not None:
            found += self._across(*split, what, span)
        for scope in inn:
            permits = self.of(scope)
            permits.entered += 1
            if not permits.free and permits.inward is None:
                hint = "put [in_through()] before the region"
                message = f"{what} goes into region {scope.name[-1]}, which does not permit it"
                self._report(rules.GOING_IN.at(span, message, hint=hint))
            found += [replace(p, count=permits.entered) for p in permits.inward or ()]
        return found

    def _across(self, start: Scope, end: Scope, what: str, span: Span) -> list[Plugin]:
        permits, name = self.of(start), end.name[-1]
        count = permits.gone[name] = permits.gone.get(name, -1) + 1
        if not permits.free and name not in permits.toward:
            near = nearest(name, permits.toward)
            self._report(
                rules.GOING_TO.at(
                    span,
                    f"{what} goes from region {start.name[-1]} to {name}, "
                    "which is not permitted",
                    hint=(
                        f"{start.name[-1]} permits the way to {near}"
                        if near
                        else f"put [to_through( {name} )] before region {start.name[-1]}"
                    ),
                )
            )
        return [replace(p, count=count) for p in permits.toward.get(name, ())]


def _crossings(
    start: Scope, end: Scope
) -> tuple[list[Scope], list[Scope], tuple[Scope, Scope] | None]:
    """Return the regions left, innermost first, those entered, outermost first, and the siblings.

    The siblings are the pair where the path crosses over; None if one region contains the other.
    """
    left, entered = list(start.outwards())[::-1], list(end.outwards())[::-1]
    level = 0
    while level < min(len(left), len(entered)) and left[level] is entered[level]:
        level += 1
    out, inn = left[level:][::-1], entered[level:]
    return out, inn, (out[-1], inn[0]) if out and inn else None
