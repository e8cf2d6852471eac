"""Reads RtcProfiles, the files of RTCBuilder (`RTC.xml`, formats 0.1 to 0.3), in XML or YAML.

Names are resolved by namespace; unknown elements are ignored; omissions and misspellings common in
real files are accepted with a warning.
"""

from __future__ import annotations

from collections.abc import Sequence
from hashlib import sha256
from pathlib import Path

from rtgen.compiler.diagnostics import Diagnostic
from rtgen.compiler.frontends import Dependency, FrontendResult, key_of
from rtgen.compiler.frontends.profiles import profile_tree
from rtgen.compiler.frontends.profiles.rtc_profile.idl_search import Search
from rtgen.compiler.frontends.profiles.rtc_profile.reader import Reader
from rtgen.compiler.kit import stages
from rtgen.compiler.model import Model, SourceFile
from rtgen.compiler.model.rtc_profile import RtcProfile
from rtgen.facts.encodings import digest

__all__ = ["load"]


def load(
    paths: Sequence[Path],
    *,
    root: Path,
    include: Sequence[Path],
    encoding: str = "auto",
    sources_of_types: Sequence[Path] = (),
) -> FrontendResult:
    """Read profiles into a model, and search for the IDL files that they use.

    These are searched for by name, or by the types of ports without a file: beside the profile, in
    a folder `idl` there or in `root`, in `include`, and in OpenRTM's folder. IDL files among
    `sources_of_types` come first. `encoding` is that of profiles in YAML that are not UTF-8. All
    errors of a file are among the diagnostics.
    """
    profiles: list[RtcProfile] = []
    files: list[SourceFile] = []
    diagnostics: list[Diagnostic] = []
    sources: dict[str, str] = {}
    dependencies: list[Dependency] = []
    idl: dict[Path, None] = {}
    for path in paths:
        file = path.as_posix()
        stages.file(file)
        findings = profile_tree.sink()
        data = profile_tree.read(path, file, findings.report)
        if data is None:
            diagnostics += findings.diagnostics
            dependencies.append(Dependency(path, None))
            continue
        dependencies.append(Dependency(path, sha256(data).hexdigest()))
        tree, sources[file] = profile_tree.parse(data, file, findings.report, encoding)
        profile = None if tree is None else Reader(file, findings).profile(tree)
        diagnostics += findings.diagnostics
        if profile is None:
            continue
        profiles.append(profile)
        key = key_of(path, root)
        files.append(SourceFile(name=file, key=key, sha256=digest(data), main=True))
        search = Search(path, root, include, sources_of_types)
        idl |= dict.fromkeys(search.files(profile))
        dependencies += search.dependencies
    return FrontendResult(
        Model(files=tuple(files), profiles=tuple(profiles)),
        tuple(diagnostics),
        sources,
        tuple(dependencies),
        tuple(idl),
    )
