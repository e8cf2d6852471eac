"""A project: `rtgen.toml`, its source files, the cache, and the output folders."""

from rtgen.compiler.kit.project_file import FILE_NAME, find
from rtgen.compiler.project.kinds import (
    is_bus_file,
    is_component_profile,
    is_other_kind,
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
from rtgen.compiler.project.paths import files, shown
from rtgen.compiler.project.run_table import RunTable, load_run_table
from rtgen.compiler.project.transport_names import ENGINES, TRANSPORTS

__all__ = [
    "ENGINES",
    "FILE_NAME",
    "OUTPUT",
    "PRELUDES",
    "SYSTEMS_TARGET",
    "TARGETS",
    "TRANSPORTS",
    "Project",
    "RunTable",
    "files",
    "find",
    "is_bus_file",
    "is_component_profile",
    "is_other_kind",
    "is_system",
    "load",
    "load_around",
    "load_run_table",
    "path_finding",
    "require_sources",
    "shown",
    "with_arguments",
]
