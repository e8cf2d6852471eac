"""The files of the target openrtm, in addition to those of the embedded target."""

from __future__ import annotations

from collections.abc import Iterator

from rtgen.compiler.backends import Artifact, Emission, Options
from rtgen.compiler.backends.components.checks import check
from rtgen.compiler.diagnostics import has_errors
from rtgen.compiler.model import Model
from rtgen.openrtm.backend import rules
from rtgen.openrtm.backend.component_files import component_files
from rtgen.openrtm.backend.plan import ROOT, Unit, own_modules, plans
from rtgen.openrtm.backend.systems import system_artifacts
from rtgen.openrtm.backend.wire_idl import WireIdl


class OpenRtmBackend:
    """Generates a folder for each component: its OpenRTM module and accompanying files."""

    name = "openrtm"

    def emit(self, model: Model, options: Options) -> Emission:
        """Return all files of all components; none if there are errors."""
        if has_errors(check(model)):
            return Emission()
        units = list(_units(model, options))
        planned, findings = plans(units)
        if planned and options.package.partition(".")[0] == ROOT:
            findings.append(
                rules.PACKAGE.at(None, f"the package cannot be called {ROOT!r}")
            )
        own = own_modules(planned)
        idl = {unit.options.package: WireIdl(unit, own) for unit in units}
        for plan in planned:
            findings += idl[plan.unit.options.package].findings(plan)
        if has_errors(findings):
            return Emission((), findings)
        origin = tuple(dict.fromkeys(plan.source.key for plan in planned))
        artifacts = [Artifact(f"{ROOT}/.gitignore", _IGNORED, origin)] * bool(planned)
        for plan in planned:
            artifacts += component_files(plan)
            artifacts += idl[plan.unit.options.package].artifacts(plan)
        systems, diagnostics = system_artifacts(model.systems, planned, options.version)
        findings += diagnostics
        artifacts += systems
        return Emission(artifacts, findings)


BACKEND = OpenRtmBackend()

_IGNORED = """\
# Made where the modules run: stubs by idlcompile.sh, run by start.sh, logs by managers.
stubs/
run/
*.log
"""


def _units(model: Model, options: Options) -> Iterator[Unit]:
    """Yield the project's own package, and those below it."""
    yield Unit(model, options, options.factories)
    for package in model.packages:
        yield Unit(package.model, options.inside(package), options.factories)
