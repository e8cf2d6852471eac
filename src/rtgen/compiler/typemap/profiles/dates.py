"""Dates of definitions and profiles: `xsd:dateTime`, restricted to the years of Python."""

from __future__ import annotations

import re
from datetime import datetime

_DATE = re.compile(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d(\.\d+)?(Z|[+-]\d\d:\d\d)?")
_FRACTION = re.compile(r"\.\d+")


def is_date(text: str) -> bool:
    """Return whether a text is a date with a time; the zone may be missing."""
    if not _DATE.fullmatch(text):
        return False
    try:
        datetime.fromisoformat(_FRACTION.sub("", text))
    except ValueError:
        return False
    return True


def has_zone(text: str) -> bool:
    """Return whether a date has a zone."""
    match = _DATE.fullmatch(text)
    return match is not None and match[2] is not None
