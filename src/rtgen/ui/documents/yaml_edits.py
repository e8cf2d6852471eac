"""Writes changed content of a YAML text; the rest of the text stays as it is."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from difflib import SequenceMatcher
from typing import Any, Final, NamedTuple, TypeAlias

Content: TypeAlias = "str | int | Sequence[Content] | Mapping[str, Content]"

_IDENTITIES: Final = ("instanceName", "connectorId", "portName", "name", "id")
"""Keys by which an item of a list is recognised after a change, the first that it has."""


class UnlikeError(Exception):
    """The text does not have the content from which a change begins."""


class _Patch(NamedTuple):
    start: int
    end: int
    text: str


def written(text: str, before: Content, after: Content) -> str:
    """Return a text of the content `before` as one of the content `after`. Raises UnlikeError."""
    import yaml

    loader = yaml.CBaseLoader if yaml.__with_libyaml__ else yaml.BaseLoader
    root = yaml.compose(text, Loader=loader)
    parts, offset = [], 0
    for patch in sorted(_Writer(text).patches(root, before, after)):
        parts += [text[offset : patch.start], patch.text]
        offset = patch.end
    return "".join((*parts, text[offset:]))


class _Writer:
    """Finds where a text changes. Nodes are those of PyYAML, which are untyped."""

    def __init__(self, text: str) -> None:
        self._text = text
        self._newline = "\r\n" if "\r\n" in text else "\n"

    def patches(self, node: Any, before: Content, after: Content) -> Iterator[_Patch]:
        """Yield the changes of the content of a node."""
        if before == after:
            return
        if getattr(node, "flow_style", False) or isinstance(before, str | int):
            yield _Patch(node.start_mark.index, self._end(node), _flow(after))
        elif isinstance(before, Mapping) and isinstance(after, Mapping):
            yield from self._mapping(node, before, after)
        elif isinstance(before, Sequence) and isinstance(after, Sequence):
            yield from self._sequence(node, before, after)
        else:
            raise UnlikeError

    def _mapping(
        self, node: Any, before: Mapping[str, Content], after: Mapping[str, Content]
    ) -> Iterator[_Patch]:
        entries = {key.value.rpartition("rts::")[2]: (key, v) for key, v in node.value}
        if not before.keys() <= entries.keys():
            raise UnlikeError
        for name, value in before.items():
            key, content = entries[name]
            if name in after:
                yield from self.patches(content, value, after[name])
            elif key is node.value[0][0]:
                raise UnlikeError  # the line may be that of a list's item, too
            else:
                yield self._removed(key.start_mark.index, content)
        added = {name: value for name, value in after.items() if name not in before}
        if added:
            yield self._inserted(node, _block(added), node.start_mark.column)

    def _sequence(
        self, node: Any, before: Sequence[Content], after: Sequence[Content]
    ) -> Iterator[_Patch]:
        items = node.value
        if len(items) != len(before):
            raise UnlikeError
        last: int | None = None
        behind: dict[int | None, list[Content]] = {}
        pairs = dict(_pairs(before, after))
        kept = {new: old for old, new in pairs.items()}
        for number, item in enumerate(items):
            if number in pairs:
                value = after[pairs[number]]
                yield from self.patches(item, before[number], value)
            else:
                yield self._removed(self._dash(item), item)
        for number, value in enumerate(after):
            if number in kept:
                last = kept[number]
            else:
                behind.setdefault(last, []).append(value)
        for place, values in behind.items():
            dash = self._dash(items[0])
            column = dash - self._line(dash)
            if place is None:
                text = _indented(_block(values), column, self._newline)
                start = self._line(dash)
                yield _Patch(start, start, text)
            else:
                yield self._inserted(items[place], _block(values), column)

    def _removed(self, start: int, node: Any) -> _Patch:
        end = self._text.find("\n", self._end(node))
        return _Patch(self._line(start), len(self._text) if end < 0 else end + 1, "")

    def _inserted(self, node: Any, block: str, column: int) -> _Patch:
        """Return the patch that adds lines behind those of a node."""
        at = self._text.find("\n", self._end(node)) + 1
        text = _indented(block, column, self._newline)
        if not at:
            at, text = len(self._text), self._newline + text
        return _Patch(at, at, text)

    def _dash(self, item: Any) -> int:
        """Return the offset of the dash of a block list's item."""
        return self._text.rindex("-", 0, item.start_mark.index)

    def _end(self, node: Any) -> int:
        """Return the end of the last character of a node; marks of blocks are behind them."""
        if isinstance(node.value, list) and not node.flow_style:
            last = node.value[-1]
            return self._end(last[1] if isinstance(last, tuple) else last)
        end: int = node.end_mark.index
        return len(self._text[:end].rstrip()) if end > node.start_mark.index else end

    def _line(self, offset: int) -> int:
        return self._text.rfind("\n", 0, offset) + 1


def _pairs(
    before: Sequence[Content], after: Sequence[Content]
) -> Iterator[tuple[int, int]]:
    """Yield the numbers of the items that are the same, or the same with changes."""
    texts = [*map(repr, before)], [*map(repr, after)]
    matcher = SequenceMatcher(None, *texts, autojunk=False)
    for kind, first, end, other, other_end in matcher.get_opcodes():
        if kind == "equal":
            yield from zip(range(first, end), range(other, other_end), strict=True)
            continue
        index_of = {_identity(before[i]): i for i in range(first, end)}
        last = first - 1
        for i in range(other, other_end):
            place = index_of.get(_identity(after[i]), -1)
            if place > last:
                last = place
                yield place, i


def _identity(item: Content) -> object:
    if not isinstance(item, Mapping):
        return item if isinstance(item, str | int) else None
    for key in _IDENTITIES:
        for name in (key, f"rtsExt::{key}"):
            if name in item:
                return name, item[name]
    return None


def _flow(content: Content) -> str:
    import yaml

    text = yaml.safe_dump(
        content,
        default_flow_style=True,
        allow_unicode=True,
        width=1 << 20,
        sort_keys=False,
    )
    return str(text).removesuffix("\n").removesuffix("\n...")


def _block(content: Content) -> str:
    import yaml

    return str(
        yaml.safe_dump(
            content,
            default_flow_style=False,
            allow_unicode=True,
            width=1 << 20,
            sort_keys=False,
        )
    )


def _indented(block: str, column: int, newline: str) -> str:
    lines = re.findall(r".*\n", block)
    return "".join(f"{' ' * column}{line[:-1]}{newline}" for line in lines)
