"""Probes: the smallest definitions that show one rule, with what is expected of them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum


class Relation(Enum):
    """What omniidl makes of a probe, in comparison with ours."""

    SAME = "both accept it, and read the same"
    REFUSED = "both refuse it"
    BETTER = "only ours accepts it, and `gives` says what it reads"
    STRICTER = "only ours refuses it"
    ALONE = "omniidl is not asked"


@dataclass(frozen=True)
class Probe:
    """A probe.

    `codes` are prefixes of the expected diagnostics' codes, in order; the exact syntax error
    (`IDL01`) is checked by the golden cases. `gives` are declarations as printed by `summary`.
    """

    name: str
    text: str | bytes
    relation: Relation
    codes: tuple[str, ...]
    gives: Mapping[str, str] = field(default_factory=dict)
    files: Mapping[str, str] = field(default_factory=dict)
    folders: tuple[str, ...] = ()
    ignore_case: bool = False


def same(
    name: str,
    text: str | bytes,
    *codes: str,
    files: Mapping[str, str] | None = None,
    folders: tuple[str, ...] = (),
    gives: Mapping[str, str] | None = None,
    ignore_case: bool = False,
) -> Probe:
    """Accepted by both with equal facts; `codes` are those of our warnings."""
    return Probe(
        name,
        text,
        Relation.SAME,
        codes,
        gives=gives or {},
        files=files or {},
        folders=folders,
        ignore_case=ignore_case,
    )


def refused(
    name: str,
    text: str | bytes,
    *codes: str,
    files: Mapping[str, str] | None = None,
    folders: tuple[str, ...] = (),
    ignore_case: bool = False,
) -> Probe:
    """Refused by both."""
    return Probe(
        name,
        text,
        Relation.REFUSED,
        codes,
        files=files or {},
        folders=folders,
        ignore_case=ignore_case,
    )


def better(
    name: str,
    text: str | bytes,
    *codes: str,
    files: Mapping[str, str] | None = None,
    gives: Mapping[str, str] | None = None,
    **more: str,
) -> Probe:
    """Legal, or common enough, but refused by omniidl; ours accepts it."""
    return Probe(
        name,
        text,
        Relation.BETTER,
        codes,
        gives={**(gives or {}), **more},
        files=files or {},
    )


def stricter(
    name: str, text: str | bytes, *codes: str, files: Mapping[str, str] | None = None
) -> Probe:
    """Wrong, but accepted by omniidl; ours refuses it."""
    return Probe(name, text, Relation.STRICTER, codes, files=files or {})


def alone(
    name: str,
    text: str | bytes,
    *codes: str,
    files: Mapping[str, str] | None = None,
    gives: Mapping[str, str] | None = None,
    **more: str,
) -> Probe:
    """CORBA 3 or IDL 4: what is expected stands here, and omniidl is not asked."""
    return Probe(
        name,
        text,
        Relation.ALONE,
        codes,
        gives={**(gives or {}), **more},
        files=files or {},
    )
