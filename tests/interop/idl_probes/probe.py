"""Probes: the smallest definitions for single rules, with their expected results."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum


class Relation(Enum):
    """Result of omniidl for a probe, compared with rtgen's."""

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
    """Return a probe that both accept with equal facts; `codes` are those of rtgen's warnings."""
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
    """Return a probe that both refuse."""
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
    """Return a legal or common definition that rtgen accepts, but omniidl refuses."""
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
    """Return an invalid definition that rtgen refuses, but omniidl accepts."""
    return Probe(name, text, Relation.STRICTER, codes, files=files or {})


def alone(
    name: str,
    text: str | bytes,
    *codes: str,
    files: Mapping[str, str] | None = None,
    gives: Mapping[str, str] | None = None,
    **more: str,
) -> Probe:
    """Return a probe of CORBA 3 or IDL 4, which is not compared with omniidl."""
    return Probe(
        name,
        text,
        Relation.ALONE,
        codes,
        gives={**(gives or {}), **more},
        files=files or {},
    )
