"""Finding and declaring names: look-up, introduction, clashes, and hints for unknown ones."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from rtgen.diagnostics import Diagnostic, Related
from rtgen.frontends.idl import tree
from rtgen.frontends.idl.rules import names as rules
from rtgen.frontends.idl.scopes import Entity, Kind, Scope, Use
from rtgen.frontends.idl.suggestions import nearest
from rtgen.frontends.idl.unit import Unit
from rtgen.frontends.idl.words import CORBA_3, FOLDED, RESERVED

_ARTICLE = {"a": "an", "e": "an", "i": "an", "o": "an"}


def called(entity: Entity) -> str:
    """The entity as messages call it: `the struct RTC::Time`."""
    return f"the {entity.kind} {entity.scoped}"


def kind_of(entity: Entity) -> str:
    """Its kind with an article: `an interface`."""
    return f"{_ARTICLE.get(entity.kind[0], 'a')} {entity.kind}"


class Lookup:
    """Looks names up in a translation unit and reports those that cannot be found."""

    def __init__(self, top: Scope, report: Callable[[Diagnostic], None]) -> None:
        self._top = top
        self._report = report
        self.doubtful = False
        """Whether an include was missing: then a name that is unknown is no news."""

    def find(
        self, scope: Scope, name: tree.ScopedName, unit: Unit, *, optional: bool = False
    ) -> Entity | None:
        """What a scoped name stands for; None, with a finding unless `optional`."""
        first = name.parts[0]
        key = first.text.lower()
        if name.absolute:
            found = self._top.find(key)
        else:
            found = []
            for place in scope.outward():
                found = place.find(key)
                if found:
                    break
        entity = self._single(found, first, unit, scope, name, optional)
        if entity is None:
            return None
        if not name.absolute and key not in scope.names:
            _introduce(scope, key, Use(entity, unit, first.start, first.end))
        for part in name.parts[1:]:
            if entity.kind is Kind.ENUM:
                entity = self._in_enum(entity, part, unit, optional)
            elif entity.inner is None:
                if not optional and not entity.poisoned:
                    self._report(
                        rules.NOT_A_SCOPE.at(
                            unit.span(part.start, part.end),
                            f"{called(entity)} has no names inside it",
                        )
                    )
                return None
            else:
                found = entity.inner.find(part.text.lower())
                entity = self._single(found, part, unit, entity.inner, None, optional)
            if entity is None:
                return None
        return entity

    def _in_enum(
        self, enum: Entity, part: tree.Name, unit: Unit, optional: bool
    ) -> Entity | None:
        found = enum.scope.names.get(part.text.lower())
        if found is None or found.owner is not enum:
            if not optional:
                self._report(
                    rules.UNKNOWN_NAME.at(
                        unit.span(part.start, part.end),
                        f"the enum {enum.scoped} has no {part.text}",
                    )
                )
            return None
        self._report(
            rules.ENUM_SCOPE.at(
                unit.span(part.start, part.end),
                f"{part.text} stands beside the enum, not inside it",
                hint=f"write {found.scoped}",
            )
        )
        return found

    def _single(
        self,
        found: list[Entity],
        part: tree.Name,
        unit: Unit,
        scope: Scope,
        whole: tree.ScopedName | None,
        optional: bool,
    ) -> Entity | None:
        if not found:
            if not optional:
                self._unknown(part, unit, scope, whole)
            return None
        if len(found) > 1:
            self._report(
                rules.AMBIGUOUS.at(
                    unit.span(part.start, part.end),
                    f"{part.text} is inherited with more than one meaning",
                    related=[Related(e.span, f"{e.kind} {e.scoped}") for e in found],
                    hint="qualify it: " + " or ".join(e.scoped for e in found),
                )
            )
            return None
        entity = found[0]
        if entity.name != part.text and not optional:
            self._report(
                rules.WRONG_CASE.at(
                    unit.span(part.start, part.end),
                    f"{part.text} is declared as {entity.name}",
                    related=[Related(entity.span, "declared here")],
                    hint=f"write {entity.name}",
                )
            )
        return entity

    def _unknown(
        self, part: tree.Name, unit: Unit, scope: Scope, whole: tree.ScopedName | None
    ) -> None:
        if self.doubtful:
            return
        span = unit.span(part.start, part.end)
        if whole is None:
            inside = f" in {called(scope.entity)}" if scope.entity else ""
            near = nearest(part.text, (e.name for e in scope.names.values()))
            hint = f"did you mean {near}?" if near else None
        else:
            inside = ""
            hint = self._hint(part.text, scope, is_value=False)
        self._report(
            rules.UNKNOWN_NAME.at(span, f"{part.text} is unknown{inside}", hint=hint)
        )

    def _hint(self, text: str, scope: Scope, *, is_value: bool) -> str | None:
        if text.lower() in ("true", "false"):
            return f"the boolean constants are TRUE and FALSE, not {text}"
        word = FOLDED.get(text.lower())
        if word is not None:
            return f"did you mean the keyword '{word}'?"
        visible = [e.name for place in scope.outward() for e in place.names.values()]
        elsewhere = [e for e in _everything(self._top) if e.name == text]
        if elsewhere:
            return "did you mean " + " or ".join(e.scoped for e in elsewhere[:3]) + "?"
        near = nearest(text, [*visible, *RESERVED])
        if near is None:
            far = {e.name: e.scoped for e in _everything(self._top)}
            name = nearest(text, far)
            near = far[name] if name else None
        return f"did you mean {near}?" if near else None

    def declare(
        self, scope: Scope, entity: Entity, escaped: bool = False
    ) -> Entity | None:
        """Enter an entity into its scope.

        Gives the entity that the scope has under that name, None where it had none. The caller
        decides whether the two go together (modules, forward declarations); `clash` reports it.
        """
        name = entity.name
        key = name.lower()
        self._spelling(entity, key, escaped)
        existing = scope.names.get(key)
        if existing is not None:
            return existing
        use = scope.introduced.get(key)
        if use is not None and use.entity is not entity:
            self._report(
                rules.INTRODUCED.at(
                    entity.span,
                    f"{name} clashes with {use.entity.name}, which is used in this scope",
                    related=[
                        Related(use.span, f"{use.entity.name} is used here"),
                        Related(use.entity.span, f"it is {called(use.entity)}"),
                    ],
                    hint=f"write ::{use.entity.scoped} there, or rename this",
                )
            )
        around = scope.entity
        if around is not None and around.name.lower() == key:
            self._report(
                rules.SAME_AS_SCOPE.at(
                    entity.span,
                    f"{name} has the name of {called(around)} around it",
                    related=[Related(around.span, "declared here")],
                )
            )
        scope.names[key] = entity
        return None

    def clash(self, entity: Entity, existing: Entity) -> None:
        """Report that a scope has that name already."""
        same = entity.name == existing.name
        rule = rules.REDECLARED if same else rules.CASE_CLASH
        message = (
            f"{entity.name} is declared twice"
            if same
            else f"{entity.name} and {existing.name} differ in case only"
        )
        self._report(
            rule.at(
                entity.span,
                message,
                related=[
                    Related(existing.span, f"the {existing.kind} is declared here")
                ],
            )
        )

    def _spelling(self, entity: Entity, key: str, escaped: bool) -> None:
        name = entity.name
        if name[0] == "_" or not name.isascii():
            what = (
                "has more than one leading underscore"
                if name[0] == "_"
                else "has other than ASCII letters"
            )
            self._report(
                rules.BAD_IDENTIFIER.at(entity.span, f"the identifier {name} {what}")
            )
        elif not escaped and key in FOLDED and name != FOLDED[key]:
            self._report(
                rules.KEYWORD_CASE.at(
                    entity.span,
                    f"{name} differs from the keyword '{FOLDED[key]}' in case only",
                    hint=f"'_{name}' stands for the name {name}",
                )
            )
        elif not escaped and name in CORBA_3:
            self._report(
                rules.CORBA_3_WORD.at(
                    entity.span,
                    f"{name} is a keyword of CORBA 3",
                    hint=f"'_{name}' stands for the name {name}",
                )
            )


def _introduce(scope: Scope, key: str, use: Use) -> None:
    for place in scope.outward():
        if key in place.names:
            return
        place.introduced.setdefault(key, use)
        if place.is_module:
            return


def _everything(top: Scope) -> Iterator[Entity]:
    pending = [top]
    while pending:
        scope = pending.pop()
        for entity in scope.names.values():
            yield entity
            if entity.inner is not None and entity.kind in (
                Kind.MODULE,
                Kind.INTERFACE,
                Kind.VALUETYPE,
            ):
                pending.append(entity.inner)
