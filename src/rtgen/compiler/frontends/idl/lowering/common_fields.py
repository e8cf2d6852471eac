"""Fields of all declarations of the model: name, place, documentation, annotations."""

from __future__ import annotations

from typing import Any

from rtgen.compiler.frontends.idl.meaning.annotations import Annotations
from rtgen.compiler.frontends.idl.names.annotation_definitions import PLACES
from rtgen.compiler.frontends.idl.names.scopes import Entity
from rtgen.compiler.frontends.idl.syntax import tree
from rtgen.compiler.frontends.idl.text.unit import Unit
from rtgen.compiler.model import Type


class CommonFields:
    """Makes the fields that all declarations have."""

    def __init__(self, annotations: Annotations) -> None:
        self._annotations = annotations

    def common(self, entity: Entity, type_: Type | None = None) -> dict[str, Any]:
        """Return the fields of a declaration."""
        item = entity.item
        return {
            "name": entity.path,
            "repository_id": entity.repository_id,
            "file": entity.unit.source.name,
            "span": entity.span,
            "doc": self.doc(item, entity.unit),
            "annotations": self._annotations.of(
                item.annotations if item else (),
                PLACES.get(entity.kind, entity.kind.value),
                entity.unit,
                type_,
            ),
        }

    def doc(
        self, item: tree.Item | tree.Enumerator | tree.Parameter | None, unit: Unit
    ) -> str:
        """Return the doc comment of an entry."""
        if item is None or item.start == item.end or not unit.comments:
            return ""
        behind_labels: list[int] = []
        if isinstance(item, tree.Item) and isinstance(item.node, tree.Case):
            behind_labels.append(item.node.type.start)
        return unit.docs.of(item.start, item.end, *behind_labels)

    def comment_says_key(self, item: tree.Item, unit: Unit) -> bool:
        """Return whether the comment after an entry marks it as a key, as `//@key` does."""
        return unit.docs.say_key(item.end)
