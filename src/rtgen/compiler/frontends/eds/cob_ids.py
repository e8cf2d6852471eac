"""Findings on the COB-IDs of services: missing, of another service, without the node-id."""

from __future__ import annotations

from collections.abc import Iterable

from rtgen.compiler.diagnostics import Rule, Span
from rtgen.compiler.frontends.eds.findings import Findings
from rtgen.compiler.frontends.eds.rules import pdos as pdo_rules
from rtgen.compiler.frontends.eds.rules import values as value_rules
from rtgen.compiler.model.canopen import (
    EXTENDED,
    INVALID,
    RPDO_COMMUNICATION,
    NodeRelative,
    Object,
    Value,
    Variable,
    cob_id_in_force,
    resolved,
)
from rtgen.facts.canopen import can_id_of
from rtgen.facts.cob_ids import Service, Standing, restricted, service_of, standing

_WORD = 0xFFFFFFFF
_PREDEFINED = range(0x081, 0x580)
"""The identifiers of emergencies and PDOs in the predefined connection set."""


def check(objects: Iterable[Object], node_id: int | None, findings: Findings) -> None:
    """Report the COB-IDs of services other than PDOs, whose reader reports those of PDOs."""
    for thing in objects:
        if thing.index >= RPDO_COMMUNICATION:
            continue
        for variable in thing.variables:
            number = variable.index, variable.subindex
            service = service_of(number)
            if service is not None:
                check_one(number, service, variable, variable.span, node_id, findings)


def check_one(
    number: tuple[int, int],
    service: Service,
    variable: Variable | None,
    span: Span,
    node_id: int | None,
    findings: Findings,
) -> None:
    """Report the COB-ID of a service; `variable` is None if the object is missing."""
    is_pdo = number[0] >= RPDO_COMMUNICATION
    rule = pdo_rules.BAD_COB_ID if is_pdo else value_rules.BAD_COB_ID
    stated = None if variable is None else variable.current
    chosen = variable is not None and variable.value is not None
    span = span if variable is None or stated is None else variable.value_span
    if not isinstance(stated, int | NodeRelative):
        if service.base is not None or is_pdo:
            missing = f"{service.name} has no COB-ID"
            findings.add(rule, span, f"{missing}; {_in_force(number, stated, node_id)}")
        return
    probe = resolved(stated, node_id or 1)
    assert isinstance(probe, int)
    cob_id = probe & _WORD
    rule, message = _problem(rule, service, stated, cob_id, chosen, node_id)
    if message:
        if standing(service, cob_id, chosen=chosen) is not Standing.STATED:
            force = _in_force(number, stated, node_id, chosen=chosen)
            message = f"{message}; {force}"
        findings.add(rule, span, message)


def _problem(
    rule: Rule,
    service: Service,
    stated: int | NodeRelative,
    cob_id: int,
    chosen: bool,
    node_id: int | None,
) -> tuple[Rule, str]:
    """Return the rule that a stated COB-ID violates, and the problem; empty if there is none."""
    can_id = can_id_of(cob_id)
    judged = standing(service, cob_id, chosen=chosen)
    if judged is Standing.OFF:
        if not restricted(can_id):
            return rule, f"{cob_id:08X}h has reserved bits"
        return rule, f"{can_id:03X}h is kept for other services"
    if judged is Standing.PREDEFINED and not can_id:
        return rule, "000h is the identifier of NMT commands"
    lacks = service.relative and not isinstance(stated, NodeRelative) and not chosen
    if judged is Standing.PREDEFINED:
        return pdo_rules.NO_NODE_ID, f"{can_id:03X}h lacks the node-id"
    is_plain = lacks and not service.fixed and node_id is None
    if is_plain and can_id in _PREDEFINED and not cob_id & (EXTENDED | INVALID):
        return (
            pdo_rules.NO_NODE_ID,
            f"{can_id:03X}h does not depend on the node-id: another node may have it",
        )
    return rule, ""


def _in_force(
    number: tuple[int, int],
    stated: Value | None,
    node_id: int | None,
    *,
    chosen: bool = False,
) -> str:
    """Return what is in force in place of a stated COB-ID."""
    service = service_of(number)
    assert service is not None
    cob_id = cob_id_in_force(number, stated, node_id, chosen=chosen)
    offset = cob_id.offset if isinstance(cob_id, NodeRelative) else cob_id
    assert isinstance(offset, int)
    if service.base is None or (not service.on and offset & INVALID):
        return f"{service.name} is not valid"
    if service.on and standing(service, offset) is Standing.OFF:
        return f"there is no {service.name}"
    shown = cob_id if isinstance(cob_id, NodeRelative) else f"{offset:X}h"
    return f"{shown} is taken"
