"""A project: `rtgen.toml`, its source files, the cache, and the output folders."""

from rtgen.compiler.project.kinds import (
    FILE_NAME,
    is_bus_file,
    is_component_profile,
    is_system,
)
from rtgen.compiler.project.loading import (
    OUTPUT,
    PRELUDES,
    SYSTEMS_TARGET,
    TARGETS,
    Project,
    load,
    load_around,
    path_finding,
    require_sources,
    with_arguments,
)
from rtgen.compiler.project.paths import files, find, shown

__all__ = [
    "FILE_NAME",
    "OUTPUT",
    "PRELUDES",
    "SYSTEMS_TARGET",
    "TARGETS",
    "Project",
    "files",
    "find",
    "is_bus_file",
    "is_component_profile",
    "is_system",
    "load",
    "load_around",
    "path_finding",
    "require_sources",
    "shown",
    "with_arguments",
]
