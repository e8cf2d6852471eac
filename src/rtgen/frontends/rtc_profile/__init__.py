"""Reads RtcProfiles, the files of RTCBuilder (`RTC.xml`, formats 0.1 to 0.3), in XML or YAML.

Names are resolved by namespace; unknown elements are ignored, what real files omit or misspell is
read with a warning.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from hashlib import sha256
from pathlib import Path

from rtgen.diagnostics import Diagnostic, InputError
from rtgen.frontends import Dependency, FrontendResult, key_of, profile_yaml
from rtgen.frontends.kit import located_xml
from rtgen.frontends.profile_yaml import YAML_SUFFIXES
from rtgen.frontends.rtc_profile.reader import Reader, idl_files
from rtgen.lowering.profiles.components import components
from rtgen.model import Model, SourceFile
from rtgen.model.rtc_profile import RtcProfile

__all__ = ["Profiles", "lowered", "read", "xml_text"]


@dataclass(frozen=True, slots=True)
class Profiles:
    """Result of `read`: the profiles without errors, and the places of their files."""

    profiles: tuple[RtcProfile, ...] = ()
    files: tuple[SourceFile, ...] = ()
    diagnostics: tuple[Diagnostic, ...] = ()
    sources: dict[str, str] = field(default_factory=dict)
    dependencies: tuple[Dependency, ...] = ()
    idl: tuple[Path, ...] = ()
    """Existing IDL files that the profiles name."""


def read(paths: Sequence[Path], *, root: Path, include: Sequence[Path]) -> Profiles:
    """Read profiles, and search for the IDL files that they name.

    These are searched for beside the profile, in a folder `idl` there, and in `include`. All
    problems of a file are in the diagnostics.
    """
    profiles: list[RtcProfile] = []
    files: list[SourceFile] = []
    found: list[Diagnostic] = []
    sources: dict[str, str] = {}
    dependencies: list[Dependency] = []
    idl: dict[Path, None] = {}
    for path in paths:
        file = path.as_posix()
        try:
            data = located_xml.read(path)
        except (OSError, ValueError) as error:
            reason = error.strerror if isinstance(error, OSError) else str(error)
            message = f"cannot open {file}: {reason}"
            found.append(located_xml.UNREADABLE.at(None, message))
            dependencies.append(Dependency(path, None))
            continue
        digest = sha256(data).hexdigest()
        dependencies.append(Dependency(path, digest))
        sources[file] = data.decode("utf-8", "replace")
        try:
            sources[file] = xml_text(data, file)
            tree = located_xml.parse(sources[file], file)
        except InputError as error:
            found += error.diagnostics
            continue
        reader = Reader(file)
        profile = reader.profile(tree)
        found += reader.diagnostics
        if profile is None:
            continue
        profiles.append(profile)
        key = key_of(path, root)
        files.append(SourceFile(name=file, key=key, sha256=digest, main=True))
        folders = (path.parent, path.parent / "idl", *include)
        for name in idl_files([profile]):
            for folder in folders:
                candidate = folder / name
                if candidate.is_file():
                    idl[candidate] = None
                    break
                dependencies.append(Dependency(candidate, None))
    return Profiles(
        tuple(profiles),
        tuple(files),
        tuple(found),
        sources,
        tuple(dependencies),
        tuple(idl),
    )


def xml_text(data: bytes, file: str) -> str:
    """The text of a profile in XML, converted from YAML if necessary. Raises InputError."""
    if file.lower().endswith(YAML_SUFFIXES):
        return profile_yaml.to_xml(data.decode("utf-8", "replace"), file)
    return located_xml.decode(data, file)


def lowered(
    read: Profiles, model: Model, given: frozenset[str] = frozenset()
) -> FrontendResult:
    """The components of profiles, with the types of the model, and placeholders for others.

    `given` are the displayed paths of the definition files that the user named.
    """
    declarations, found = components(read.profiles, model, given)
    return FrontendResult(
        Model(files=read.files, declarations=declarations),
        (*read.diagnostics, *found),
        read.sources,
        read.dependencies,
    )
