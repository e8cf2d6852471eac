"""All rules by their codes, for `rtgen explain`."""

from __future__ import annotations

from functools import cache
from importlib import import_module
from types import MappingProxyType

from rtgen.compiler.diagnostics import Rule, ToolError
from rtgen.compiler.kit import plugins
from rtgen.compiler.kit.translation import (
    ENGLISH,
    language,
    translated,
    translated_page,
    translated_paragraph,
)
from rtgen.compiler.kit.translation.blocks import paragraphs

MODULES = {
    "rtgen.compiler.backends.canopen.rules": "EDS",
    "rtgen.compiler.backends.components.rules": "RTC",
    "rtgen.compiler.backends.kit.rules": "PRJ",
    "rtgen.openrtm.backend.rules": "RTC",
    "rtgen.openrtm.backend.system_rules": "RTC",
    "rtgen.ros2.backend.rules": "ROS",
    "rtgen.compiler.backends.small.rules": "RTC",
    "rtgen.compiler.lowering.tecs.rules": "CDL",
    "rtgen.compiler.backends.types.rules": "PY",
    "rtgen.compiler.backends.typescript.rules": "TS",
    "rtgen.tools.diff.kinds.catalogue": "DIF",
    "rtgen.compiler.frontends.bus.rules": "EDS",
    "rtgen.compiler.frontends.cdl.rules": "CDL",
    "rtgen.compiler.frontends.eds.rules": "EDS",
    "rtgen.compiler.frontends.idl.rules": "IDL",
    "rtgen.compiler.frontends.kit.character_rules": "TXT",
    "rtgen.openrtm.python_modules.rules": "RTC",
    "rtgen.ros2.rosidl.rules": "ROS",
    "rtgen.compiler.typemap.profiles.rules": "RTC",
    "rtgen.compiler.frontends.kit.xml_rules": "RTC",
    "rtgen.compiler.frontends.profiles.rules": "RTC",
    "rtgen.tools.fmt.rules": "FMT",
    "rtgen.compiler.lint.rules": "LINT",
    "rtgen.compiler.project_rules": "ENV PRJ",
    "rtgen.tools.scaffold.rules": "NEW",
    "rtgen.compiler.lowering.adapter_rules": "ADP",
    "rtgen.compiler.lowering.numeric_rules": "NUM",
    "rtgen.compiler.lowering.canopen.rules": "EDS",
    "rtgen.compiler.systems.connection_rules": "RTC",
    "rtgen.compiler.systems.rules": "SYS",
}
"""The modules of rtgen that define `RULES`, with the letters of their codes."""


def rule_of(code: str) -> Rule | None:
    """Return the rule of a code, in any case.

    Only modules with such codes are imported, unless plug-ins have rules. Raises ToolError for an
    invalid one.
    """
    code = code.upper()
    letters = code.rstrip("0123456789")
    for name, own in MODULES.items():
        if letters in own.split() and not plugins.announced(plugins.Group.RULES):
            for rule in import_module(name).RULES:
                if rule.code == code:
                    assert isinstance(rule, Rule)
                    return rule
    return rules().get(code)


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
    from difflib import get_close_matches

    return get_close_matches(code.upper(), rules(), n=3)


def story(rule: Rule) -> str:
    """Return the rule as Markdown, in the language of the user."""
    title = translated(rule.title)
    explanation = rule.explanation.strip()
    page = translated_page(explanation)
    if language() != ENGLISH and all(
        t == translated_paragraph(t) for t in paragraphs(explanation)
    ):
        page = f"{translated('This explanation is in English only.')}\n\n{page}"
    return f"# {rule.code}: {title}\n\n{page}\n"
