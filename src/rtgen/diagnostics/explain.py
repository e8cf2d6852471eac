"""All rules by their codes, for `rtgen explain`."""

from __future__ import annotations

from difflib import get_close_matches
from functools import cache
from importlib import import_module
from types import MappingProxyType

from rtgen import plugins
from rtgen.diagnostics import Rule, ToolError

MODULES = (
    "rtgen.backends.canopen.rules",
    "rtgen.backends.components.rules",
    "rtgen.backends.kit.rules",
    "rtgen.backends.openrtm.rules",
    "rtgen.backends.openrtm.system_rules",
    "rtgen.backends.ros_interfaces.rules",
    "rtgen.backends.small.rules",
    "rtgen.lowering.tecs.rules",
    "rtgen.backends.types.rules",
    "rtgen.backends.typescript.rules",
    "rtgen.diff.kinds.catalogue",
    "rtgen.frontends.bus.rules",
    "rtgen.frontends.cdl.rules",
    "rtgen.frontends.eds.rules",
    "rtgen.frontends.idl.rules",
    "rtgen.frontends.kit.characters",
    "rtgen.frontends.openrtm_python.rules",
    "rtgen.frontends.rosidl.rules",
    "rtgen.typemap.profiles.rules",
    "rtgen.frontends.rts_profile",
    "rtgen.formatting.rules",
    "rtgen.lint.rules",
    "rtgen.project.rules",
    "rtgen.scaffold.rules",
    "rtgen.lowering.adapter_rules",
    "rtgen.lowering.numeric_rules",
    "rtgen.lowering.canopen.rules",
    "rtgen.systems.checks",
    "rtgen.systems.rules",
)
"""The modules of rtgen that define `RULES`."""


@cache
def rules() -> MappingProxyType[str, Rule]:
    """Return all rules by code, sorted, with those of plug-ins. Raises ToolError for an invalid
    one.
    """
    found: dict[str, Rule] = {}
    for name in MODULES:
        for rule in import_module(name).RULES:
            assert rule.code not in found, f"{rule.code} is the code of two rules"
            found[rule.code] = rule
    for name, brought in plugins.loaded(plugins.Group.RULES):
        with plugins.running(plugins.Group.RULES, name):
            own = plugins.require_each(Rule, brought)
        for rule in own:
            if rule.code in found:
                raise ToolError(
                    f"the rules of the plug-in {name!r} have the code {rule.code}, which is taken",
                    hint="uninstall one of the packages",
                )
            found[rule.code] = rule
    return MappingProxyType(dict(sorted(found.items())))


def similar(code: str) -> list[str]:
    """Return the codes most similar to an unknown `code`."""
    return get_close_matches(code.upper(), rules(), n=3)


def story(rule: Rule) -> str:
    """Return the rule as Markdown."""
    return f"# {rule.code}: {rule.title}\n\n{rule.explanation.strip()}\n"
