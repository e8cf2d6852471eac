"""Tests a running component over CORBA."""

from __future__ import annotations

from collections.abc import Collection
from contextlib import closing
from functools import partial
from pathlib import Path
from typing import Any

from omniORB import CORBA

from rtgen.compiler import compilation
from rtgen.compiler.diagnostics import InputError, ToolError, has_errors
from rtgen.compiler.frontends.profiles.profile_yaml import YAML_SUFFIXES
from rtgen.compiler.project import (
    is_component_profile,
    load,
    require_sources,
    with_arguments,
)
from rtgen.runtime.corba.naming import Naming
from rtgen.runtime.corba.orb import Orb
from rtgen.runtime.corba.rt_objects.foreign import is_place, located
from rtgen.runtime.corba.rt_objects.objects import Exported
from rtgen.runtime.errors import NoNamingServiceError, TransportError
from rtgen.tools.components.chosen_component import chosen
from rtgen.tools.conformance.check import Permission
from rtgen.tools.conformance.report import Report
from rtgen.tools.conformance.rtc.checks import CHECKS
from rtgen.tools.conformance.rtc.component import RtcUnderTest
from rtgen.tools.conformance.rtc.expected import Expected
from rtgen.tools.conformance.subject import Subject
from rtgen.tools.kit.exits import Refusal
from rtgen.tools.kit.signals import terminable

_PROFILES = (".xml", *YAML_SUFFIXES)


def tested(file: Path | None, subject: Subject) -> Report:
    """Return the report of all checks. Raises InputError, Refusal and ToolError."""
    connect, timeout = subject.connect, subject.timeout
    if not is_place(connect):
        raise Refusal(
            f"{connect!r} is not a place of a component: HOST[:PORT]/NAME.rtc, corbaname:, "
            "corbaloc: or IOR:"
        )
    expected, definition = _expected(file, subject.component, subject.include)
    try:
        with closing(Orb(timeout=timeout)) as orb:
            exported = Exported(orb, gives_up=False)
            reference = located(connect, exported, partial(Naming, orb.orb))
            rtc = _answering(connect, expected, reference, exported, timeout)
            name = f"{expected.type_name} {rtc.profile.instance_name}"
            return checked(rtc, name, definition, subject.permissions)
    except NoNamingServiceError as error:
        hint = "rtgen run and OpenRTM's rtc.conf name the naming service of a component"
        raise ToolError(str(error), hint=hint) from error
    except TransportError as error:
        raise ToolError(str(error)) from error


def _expected(
    file: Path | None, name: str | None, include: tuple[str, ...]
) -> tuple[Expected, str]:
    """Return what is expected of a component, and the file that says so. Raises InputError."""
    is_profile = file is not None and file.suffix.lower() in _PROFILES
    if file and is_profile and file.is_file() and not is_component_profile(file):
        raise Refusal(f"{file} is not the profile of a component (RTC.xml)")
    paths = () if file is None else (str(file),)
    project = with_arguments(load(), paths=paths, include=include)
    if file is None:
        require_sources(project)
    read = compilation.read(project, lowered=True)
    if has_errors(read.diagnostics):
        raise InputError(read.diagnostics)
    component = chosen(read.model, None if file is None else str(file), name)
    definition = component.file if file is None else file.as_posix()
    return Expected(read.model, component), definition


def _answering(
    connect: str, expected: Expected, reference: Any, exported: Exported, timeout: float
) -> RtcUnderTest:
    """Return the component at a place. Raises ToolError."""
    if reference is None:
        raise ToolError(
            f"there is no component at {connect}",
            hint="rtls of rtshell shows the paths of running components",
        )
    try:
        return RtcUnderTest(expected, reference, exported, timeout)
    except CORBA.SystemException as error:
        raise ToolError(
            f"the object at {connect} does not respond as a component: {error!r}"
        ) from error


def checked(
    rtc: RtcUnderTest,
    subject: str,
    definition: str,
    permissions: Collection[Permission],
) -> Report:
    """Return the report of all checks. The component is left unchanged, also after Ctrl-C."""
    try:
        if Permission.ACTUATE in permissions and rtc.contexts:
            rtc.keep()
    except rtc.faults as fault:
        why = rtc.explained(fault)
        raise ToolError(
            f"{subject} does not report the state that --actuate would have to restore: {why}",
            hint="without --actuate nothing is changed",
        ) from fault
    try:
        with terminable():
            outcomes = tuple(check.outcome(rtc, permissions) for check in CHECKS)
    except BaseException:
        wrong = [problem for problem in rtc.restore() if problem is not None]
        if wrong:
            what = "; ".join(wrong)
            raise ToolError(f"{subject} was not restored: {what}") from None
        raise
    return Report(subject, definition, outcomes)
