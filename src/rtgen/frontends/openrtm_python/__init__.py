"""Front end for modules of OpenRTM-aist-Python (rtc-template, RTCBuilder): read, never executed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from rtgen.diagnostics import Diagnostic
from rtgen.frontends.openrtm_python.modules import Modules
from rtgen.frontends.openrtm_python.reader import ModuleReader
from rtgen.frontends.openrtm_python.source import read_source
from rtgen.frontends.openrtm_python.values import Module
from rtgen.model.rtc_profile import RtcProfile


@dataclass(frozen=True, slots=True)
class ModuleResult:
    """What `read` gives: no profile if there are errors; `sources` are texts by displayed path.

    Beside a module that rtgen made, `generated`, there is an RtcProfile that says more.
    """

    profile: RtcProfile | None
    diagnostics: tuple[Diagnostic, ...]
    sources: Mapping[str, str]
    generated: bool = False


def read(path: Path, include: Sequence[Path] = ()) -> ModuleResult:
    """The component of a module. Whatever is wrong with the file is in the diagnostics.

    Modules that it imports are looked for beside it, up to the folder of the repository, and in
    `include`.
    """
    source = read_source(path)
    if source.tree is None:
        return ModuleResult(None, source.diagnostics, {source.file: source.text})
    modules = Modules(path, include)
    reader = ModuleReader(Module(source, source.tree), modules)
    profile = reader.profile()
    read = (source, *modules.sources)
    found = [d for each in read for d in each.diagnostics]
    return ModuleResult(
        profile,
        (*found, *reader.diagnostics),
        {each.file: each.text for each in read},
        reader.generated,
    )
