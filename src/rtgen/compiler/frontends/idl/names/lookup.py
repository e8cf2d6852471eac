"""Declares and looks up names; reports clashes and unknown names, with hints."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import msgspec

from rtgen.compiler.diagnostics import Diagnostic, Related, Span
from rtgen.compiler.frontends.idl.names.scopes import TYPES, Entity, Kind, Scope, Use
from rtgen.compiler.frontends.idl.rules import names as rules
from rtgen.compiler.frontends.idl.syntax import tree
from rtgen.compiler.frontends.idl.syntax.keywords import CORBA_3, FOLDED, RESERVED
from rtgen.compiler.frontends.idl.text.unit import Unit
from rtgen.compiler.frontends.kit.suggestions import nearest
from rtgen.facts.ros import is_interface

MAX_ELSEWHERE = 3
"""Maximum number of further places in a diagnostic."""
_MAX_GUESSES = 200
"""Maximum number of unknown names for which similar names are searched, which is slow."""

_INCLUDE = 'it is declared in {0}: write #include "{0}"'
_NO_GUESS = "declare it before its use, or include the file that declares it"

_TAGGED = (Kind.STRUCT, Kind.UNION, Kind.ENUM)

_NAMEABLE = TYPES | {Kind.MODULE, Kind.EXCEPTION, Kind.CONST, Kind.ENUMERATOR}
_USED_OUT_TO = (Kind.INTERFACE, Kind.VALUETYPE, Kind.COMPONENT, Kind.HOME)
_ARTICLE = {"a": "an", "e": "an", "i": "an", "o": "an"}


def called(entity: Entity) -> str:
    """Return the entity as shown in messages, such as `the struct RTC::Time`."""
    return f"the {entity.kind} {entity.scoped}"


def kind_of(entity: Entity) -> str:
    """Return the kind of an entity with an article: `an interface`."""
    return f"{_ARTICLE.get(entity.kind[0], 'a')} {entity.kind}"


class _Unknown(msgspec.Struct, frozen=True):
    """An unknown name; `inside` is the scope of a qualified name's last part."""

    text: str
    span: Span
    scope: Scope
    inside: bool
    unit: Unit


CASE_ALLOWED = (
    'or allow it, as DDS and ROS 2 do: [idl] case = "dds" in rtgen.toml, '
    "or --ignore-case-clashes"
)
"""What makes names that differ in case only different names."""


class Lookup:
    """Looks up names in a translation unit, and reports unknown ones.

    `declares` returns the file near a unit that declares names, for hints.
    """

    def __init__(
        self,
        top: Scope,
        report: Callable[[Diagnostic], None],
        declares: Callable[[tuple[str, ...], Unit], str | None],
        ignore_case_clashes: bool,
    ) -> None:
        self._folds = not ignore_case_clashes
        self.key: Callable[[str], str] = str.lower if self._folds else str
        """The key of a name in its scope."""
        self._top = top
        self._report = report
        self._declares = declares
        self._unknowns: list[_Unknown] = []
        self._read_twice: set[str] = set()
        self.doubtful = False
        """Whether an include is missing; unknown names are then not reported."""
        self.maybe_declared: set[str] = set()
        """Names, in lower case, that declarations with syntax errors may have declared."""

    def find(
        self,
        scope: Scope,
        name: tree.ScopedName,
        unit: Unit,
        *,
        optional: bool = False,
        introduce: bool = True,
    ) -> Entity | None:
        """Look up a scoped name; None, with a diagnostic unless `optional`, if it is unknown.

        With `introduce` the use prevents a later declaration of the name in the scope.
        """
        first = name.parts[0]
        key = self.key(first.text)
        if name.absolute:
            entities = self._top.find(key)
        else:
            entities = []
            for place in scope.outward():
                entities = place.find(key)
                if entities:
                    break
        entity = self._single(entities, first, unit, scope, name, optional)
        if entity is None:
            return None
        if introduce and not name.absolute and key not in scope.names:
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
                            related=[Related(entity.span, "declared here")],
                            hint="'::' follows a module, an interface or a struct",
                        )
                    )
                return None
            else:
                entities = entity.inner.find(self.key(part.text))
                entity = self._single(
                    entities, part, unit, entity.inner, None, optional
                )
            if entity is None:
                return None
        return entity

    def is_declared(self, scope: Scope, name: tree.ScopedName) -> bool:
        """Return whether a name refers to a declaration with exactly this spelling."""
        first = name.parts[0].text
        places = [self._top] if name.absolute else scope.outward()
        entities: list[Entity] = []
        for place in places:
            entities = place.find(self.key(first))
            if entities:
                break
        for part in name.parts[1:]:
            inner = entities[0].inner if entities else None
            entities = inner.find(self.key(part.text)) if inner is not None else []
        return bool(entities) and entities[0].name == name.parts[-1].text

    def _in_enum(
        self, enum: Entity, part: tree.Name, unit: Unit, optional: bool
    ) -> Entity | None:
        entity = enum.scope.names.get(self.key(part.text))
        if entity is None or entity.owner is not enum:
            if not optional:
                self._report(
                    rules.UNKNOWN_NAME.at(
                        unit.span(part.start, part.end),
                        f"the enum {enum.scoped} has no {part.text}",
                        related=[Related(enum.span, "declared here")],
                        hint=_enumerators(enum, part.text),
                    )
                )
            return None
        self._report(
            rules.ENUM_SCOPE.at(
                unit.span(part.start, part.end),
                f"{part.text} is declared beside the enum, not inside it",
                hint=f"write {entity.scoped}",
            )
        )
        return entity

    def _single(
        self,
        entities: list[Entity],
        part: tree.Name,
        unit: Unit,
        scope: Scope,
        whole: tree.ScopedName | None,
        optional: bool,
    ) -> Entity | None:
        if not entities:
            if not optional:
                self._unknown(part, unit, scope, whole)
            return None
        if len(entities) > 1:
            self._report(
                rules.AMBIGUOUS.at(
                    unit.span(part.start, part.end),
                    f"{part.text} is inherited with more than one meaning",
                    related=[Related(e.span, f"{e.kind} {e.scoped}") for e in entities],
                    hint="qualify it: " + " or ".join(e.scoped for e in entities),
                )
            )
            return None
        entity = entities[0]
        if entity.name != part.text and not optional:
            self.wrong_case(part.text, entity, unit.span(part.start, part.end))
            return entity if entity.kind in _NAMEABLE else None
        return entity

    def wrong_case(self, text: str, entity: Entity, span: Span) -> None:
        """Report a name whose case differs from its declaration."""
        self._report(
            rules.WRONG_CASE.at(
                span,
                f"{text} is declared as {entity.name}",
                related=[Related(entity.span, "declared here")],
                hint=f"write {entity.name}",
            )
        )

    def _unknown(
        self, part: tree.Name, unit: Unit, scope: Scope, whole: tree.ScopedName | None
    ) -> None:
        if self.doubtful or part.text.lower() in self.maybe_declared:
            return
        places = scope.outward() if whole and not whole.absolute else [scope]
        if any(place.doubtful for place in places):
            return
        span = unit.span(part.start, part.end)
        self._unknowns.append(_Unknown(part.text, span, scope, whole is None, unit))

    def report_unknown(self) -> None:
        """Report unknown names, after all declarations are known.

        A name that is unknown in several places is reported once.
        """
        uses: dict[tuple[str, Scope | None], list[_Unknown]] = {}
        for use in self._unknowns:
            key = use.text, use.scope if use.inside else None
            uses.setdefault(key, []).append(use)
        for number, (unknown, *more) in enumerate(uses.values()):
            inside = ""
            related = [
                Related(use.span, "used here, too") for use in more[:MAX_ELSEWHERE]
            ]
            if len(more) > MAX_ELSEWHERE:
                others = len(more) - MAX_ELSEWHERE
                label = f"used here, too, and in {others} more places"
                related[-1] = Related(related[-1].span, label)
            if unknown.inside:
                entity = unknown.scope.entity
                inside = f" in {called(entity)}" if entity else ""
            hint = None
            if number >= _MAX_GUESSES:
                hint = _NO_GUESS
            elif unknown.inside:
                hint = self._hint_inside(unknown)
            else:
                later = self._later(unknown)
                if later is not None:
                    place = f"{later.span.file}:{later.span.line}"
                    hint = f"it is declared later, at {place}: move that before its use"
                    related.insert(0, Related(later.span, "declared here, too late"))
                hint = hint or self._hint(unknown)
            message = f"{unknown.text} is unknown{inside}"
            self._report(
                rules.UNKNOWN_NAME.at(unknown.span, message, related=related, hint=hint)
            )

    def _later(self, unknown: _Unknown) -> Entity | None:
        """Return a visible declaration of the name that follows its use."""
        for place in unknown.scope.outward():
            for entity in place.find(self.key(unknown.text)):
                if entity.name == unknown.text:
                    return entity
        return None

    def _hint_inside(self, unknown: _Unknown) -> str:
        entity = unknown.scope.entity
        names = {e.name: e for e in unknown.scope.names.values()}
        later = names.get(unknown.text)
        if later is not None:
            place = f"{later.span.file}:{later.span.line}"
            return f"it is declared later, at {place}: move that before its use"
        if entity is not None and entity.kind is Kind.MODULE:
            file = self._declares((entity.name, unknown.text), unknown.unit)
            if file is not None:
                return _INCLUDE.format(file)
        near = nearest(unknown.text, names)
        if near:
            return f"did you mean {near}?"
        what = called(entity) if entity else "the global scope"
        return f"declare it in {what}, or correct its name"

    def _hint(self, unknown: _Unknown) -> str:
        from rtgen.compiler.frontends.idl.syntax.foreign_words import TYPES, VALUES

        text, scope = unknown.text, unknown.scope
        anywhere = [e for e in _everything(self._top) if e.kind in _NAMEABLE]
        elsewhere = [e for e in anywhere if e.name == text]
        if elsewhere:
            names = [e.scoped for e in elsewhere[:MAX_ELSEWHERE]]
            return f"did you mean {' or '.join(names)}?"
        foreign = TYPES.get(text) or VALUES.get(text.lower())
        if foreign is not None:
            return foreign
        file = self._declares((text,), unknown.unit)
        if file is not None:
            return _INCLUDE.format(file)
        word = FOLDED.get(text.lower())
        if word is not None:
            return f"did you mean the keyword '{word}'?"
        visible = [
            entity.name
            for place in scope.outward()
            for entity in place.names.values()
            if entity.kind in _NAMEABLE
        ]
        near = nearest(text, [*visible, *RESERVED])
        if near is None:
            far = {e.name: e.scoped for e in anywhere}
            name = nearest(text, far)
            near = far[name] if name else None
        if near is None:
            return _NO_GUESS
        return f"did you mean {near}?"

    def declare(
        self, scope: Scope, entity: Entity, escaped: bool = False
    ) -> Entity | None:
        """Enter an entity into its scope.

        Returns the entity that the scope already has under the name, or None. The caller decides
        whether the two are compatible (modules, forward declarations); `clash` reports it.
        """
        name = entity.name
        key = self.key(name)
        self._spelling(entity, escaped)
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
                    hint=_allowed(
                        f"write ::{use.entity.scoped} there, or rename this",
                        name != use.entity.name,
                    ),
                )
            )
        around = scope.entity
        if (
            around is not None
            and self.key(around.name) == key
            and around.kind is not Kind.OPERATION
            # ROS 2 itself has a field `uuid` in the message UUID.
            and (name == around.name or not is_interface(around.scoped.split("::")))
        ):
            self._report(
                rules.SAME_AS_SCOPE.at(
                    entity.span,
                    f"{name} has the name of {called(around)} around it",
                    related=[Related(around.span, "declared here")],
                    hint=_allowed("rename one of them", name != around.name),
                )
            )
        scope.names[key] = entity
        return None

    def clash(self, entity: Entity, existing: Entity) -> None:
        """Report that the name is already used in its scope."""
        same = entity.name == existing.name
        if entity.span == existing.span:
            file = entity.span.file
            if self.doubtful or file in self._read_twice:
                return
            self._read_twice.add(file)
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
                hint=_allowed(_hint_for_clash(entity, existing), not same),
            )
        )

    def _spelling(self, entity: Entity, escaped: bool) -> None:
        name = entity.name
        key = name.lower()
        if not name[0].isalpha() or not name.isascii():
            if not name.isascii():
                what = "has letters other than ASCII"
            elif not name.strip("_"):
                what = "has nothing but underscores"
            elif name[0] == "_":
                what = "has more than one leading underscore"
            else:
                what = "has no letter after its underscore"
            hint = (
                f"write {name.lstrip('_') or 'a name'}"
                if name[0] == "_"
                else "names hold the letters a to z, digits and underscores"
            )
            message = f"the identifier {name} {what}"
            self._report(rules.BAD_IDENTIFIER.at(entity.span, message, hint=hint))
        elif self._folds and not escaped and key in FOLDED and name != FOLDED[key]:
            self._report(
                rules.KEYWORD_CASE.at(
                    entity.span,
                    f"{name} differs from the keyword '{FOLDED[key]}' in case only",
                    hint=_allowed(f"'_{name}' is the escaped form of {name}", True),
                )
            )
        elif not escaped and name in CORBA_3:
            self._report(
                rules.CORBA_3_WORD.at(
                    entity.span,
                    f"{name} is a keyword of CORBA 3",
                    hint=f"'_{name}' is the escaped form of {name}",
                )
            )


def _enumerators(enum: Entity, text: str) -> str:
    """Return a hint: an enumerator similar to `text`, or all enumerators if they are few."""
    names = [e.name for e in enum.scope.names.values() if e.owner is enum]
    near = nearest(text, names)
    return f"did you mean {near}?" if near else f"it has {', '.join(names[:6])}"


def _allowed(hint: str, by_case: bool) -> str:
    """Return a hint about a clash, with the setting that allows it if only case differs."""
    return f"{hint}; {CASE_ALLOWED}" if by_case else hint


def _hint_for_clash(entity: Entity, existing: Entity) -> str:
    kinds = {entity.kind, existing.kind}
    if entity.span == existing.span:
        return "the file is read twice: give it an include guard, or #pragma once"
    if kinds == {Kind.OPERATION}:
        return "operations cannot be overloaded: give each a name of its own"
    enum = existing.owner.node if existing.owner else None
    own = isinstance(enum, tree.Enum) and entity.node in enum.members
    if kinds == {Kind.ENUMERATOR} and not own:
        return "enumerators stand beside their enum: rename one, or give each enum a module"
    begin = entity.item.start if entity.item else entity.start
    in_place = entity.unit is existing.unit and begin <= existing.start
    if entity.kind is Kind.TYPEDEF and existing.kind in _TAGGED and in_place:
        return f"write '{existing.kind} {existing.name} {{ ... }};' without typedef"
    return "rename one of them"


def _introduce(scope: Scope, key: str, use: Use) -> None:
    """Record a use in its scope, and in enclosing ones up to an interface or similar."""
    around = list(scope.outward())
    ends = [
        i for i, p in enumerate(around) if p.entity and p.entity.kind in _USED_OUT_TO
    ]
    places = around[: ends[0] + 1] if ends else [scope]
    for place in places:
        if key in place.names:
            return
        place.introduced.setdefault(key, use)


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
