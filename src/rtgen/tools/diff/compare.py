"""Compares two versions in all input languages, then determines the affected users."""

from __future__ import annotations

from rtgen.tools.diff.buses import compare_buses
from rtgen.tools.diff.cells import compare_cells
from rtgen.tools.diff.changes import Change
from rtgen.tools.diff.components import compare_components
from rtgen.tools.diff.declarations import compare_declarations
from rtgen.tools.diff.devices import compare_devices
from rtgen.tools.diff.interfaces import compare_interfaces
from rtgen.tools.diff.project_settings import compare_settings
from rtgen.tools.diff.signatures import TecsSides, compare_signatures
from rtgen.tools.diff.systems import compare_systems
from rtgen.tools.diff.users import users_of, with_users
from rtgen.tools.diff.versions import Version


def compare(old: Version, new: Version) -> list[Change]:
    """Return the changes between two versions, by code and subject."""
    types = compare_declarations(old, new)
    found = [*types.changes]
    found += compare_interfaces(old, new, types)
    found += compare_components(old, new, types.names)
    sides = TecsSides(old, new)
    found += compare_signatures(old, new, sides)
    found += compare_cells(old, new, sides)
    for compared in (compare_devices, compare_buses, compare_systems, compare_settings):
        found += compared(old, new)
    users = users_of((old, new))
    return sorted(
        (_relabelled(each, old, new) for each in with_users(found, users)),
        key=lambda c: (c.kind.code, c.subject, c.message),
    )


def _relabelled(each: Change, old: Version, new: Version) -> Change:
    return each._replace(
        old=None if each.old is None else old.relabel(each.old),
        new=None if each.new is None else new.relabel(each.new),
    )
