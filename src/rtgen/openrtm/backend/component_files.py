"""The files of a component other than IDL: module, configuration, profile."""

from __future__ import annotations

from collections.abc import Iterator

from rtgen.compiler.backends import Artifact
from rtgen.compiler.backends.kit.python_text import header_comment
from rtgen.compiler.backends.kit.quoting.python import number_literal
from rtgen.compiler.backends.kit.rendering import render
from rtgen.compiler.backends.profiles.rtc_profile import profile_text
from rtgen.compiler.typemap.components.parameters import Parameters
from rtgen.openrtm.backend.component_module import component_module
from rtgen.openrtm.backend.plan import ComponentPlan


def component_files(plan: ComponentPlan) -> Iterator[Artifact]:
    """Yield `<Component>.py`, `<Component>.conf`, `rtc.conf` and `RTC.xml`."""
    component, options, source = plan.component, plan.unit.options, plan.source
    parameters = Parameters(plan.unit.model)
    values = {
        "header": header_comment(options.version, [source.key]),
        "name": plan.name,
        "category": component.category,
        "execution": component.execution,
        "rate": number_literal(float(component.rate)),
    }
    conf = render(
        "openrtm/component.conf.j2",
        parameters=[
            (each.parameter.name, parameters.default_text(each.parameter))
            for each in plan.parameters
        ],
        **values,
    )
    for name, text in (
        (f"{plan.name}.py", component_module(plan)),
        (f"{plan.name}.conf", conf),
        ("rtc.conf", render("openrtm/rtc.conf.j2", **values)),
        ("RTC.xml", profile_text(plan.unit.model, component, options)),
    ):
        yield Artifact(f"{plan.folder}/{name}", text, (source.key,))
