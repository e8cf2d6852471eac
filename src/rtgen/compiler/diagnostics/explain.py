"""All rules by their codes, for `rtgen explain`."""

from __future__ import annotations

from difflib import get_close_matches
from functools import cache
from importlib import import_module
from types import MappingProxyType

from rtgen.compiler.diagnostics import Rule, ToolError
from rtgen.compiler.kit import plugins
from rtgen.compiler.kit.translation import translated, translated_page

MODULES = (
    "rtgen.compiler.backends.canopen.rules",
    "rtgen.compiler.backends.components.rules",
    "rtgen.compiler.backends.kit.rules",
    "rtgen.openrtm.backend.rules",
    "rtgen.openrtm.backend.system_rules",
    "rtgen.ros2.backend.rules",
    "rtgen.compiler.backends.small.rules",
    "rtgen.compiler.lowering.tecs.rules",
    "rtgen.compiler.backends.types.rules",
    "rtgen.compiler.backends.typescript.rules",
    "rtgen.tools.diff.kinds.catalogue",
    "rtgen.compiler.frontends.bus.rules",
    "rtgen.compiler.frontends.cdl.rules",
    "rtgen.compiler.frontends.eds.rules",
    "rtgen.compiler.frontends.idl.rules",
    "rtgen.compiler.frontends.kit.characters",
    "rtgen.openrtm.python_modules.rules",
    "rtgen.ros2.rosidl.rules",
    "rtgen.compiler.typemap.profiles.rules",
    "rtgen.compiler.frontends.profiles.rts_profile",
    "rtgen.tools.fmt.rules",
    "rtgen.compiler.lint.rules",
    "rtgen.compiler.project.rules",
    "rtgen.tools.scaffold.rules",
    "rtgen.compiler.lowering.adapter_rules",
    "rtgen.compiler.lowering.numeric_rules",
    "rtgen.compiler.lowering.canopen.rules",
    "rtgen.compiler.systems.checks",
    "rtgen.compiler.systems.rules",
)
"""The modules of rtgen that define `RULES`."""


@cache
def rules() -> MappingProxyType[str, Rule]:
    """Return all rules by code, sorted, with those of plug-ins. Raises ToolError for an invalid
    one.
    """
    rules_by_code: dict[str, Rule] = {}
    for name in MODULES:
        for rule in import_module(name).RULES:
            assert (
                rule.code not in rules_by_code
            ), f"{rule.code} is the code of two rules"
            rules_by_code[rule.code] = rule
    for name, brought in plugins.loaded(plugins.Group.RULES):
        with plugins.running(plugins.Group.RULES, name):
            own = plugins.require_each(Rule, brought)
        for rule in own:
            if rule.code in rules_by_code:
                raise ToolError(
                    f"the rules of the plug-in {name!r} have the code {rule.code}, which is taken",
                    hint="uninstall one of the packages",
                )
            rules_by_code[rule.code] = rule
    return MappingProxyType(dict(sorted(rules_by_code.items())))


def similar(code: str) -> list[str]:
    """Return the codes most similar to an unknown `code`."""
    return get_close_matches(code.upper(), rules(), n=3)


def story(rule: Rule) -> str:
    """Return the rule as Markdown, in the language of the user."""
    title = translated(rule.title)
    page = translated_page(rule.explanation.strip())
    return f"# {rule.code}: {title}\n\n{page}\n"
