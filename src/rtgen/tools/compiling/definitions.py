"""Definitions named by a user, and the project with them."""

from __future__ import annotations

import msgspec

from rtgen.compiler.kit import stages
from rtgen.compiler.project import Project, load, require_sources, with_arguments


class Definitions(msgspec.Struct, frozen=True, kw_only=True):
    """The definitions named on the command line, with the options for reading them."""

    paths: tuple[str, ...]
    include: tuple[str, ...]
    define: tuple[tuple[str, str], ...]
    ignore_case_clashes: bool
    prelude: str | None
    encoding: str | None


def project_of(
    definitions: Definitions,
    output: str | None = None,
    add: bool = False,
    node_id: int | None = None,
    target: str | None = None,
    judged: bool = False,
) -> Project:
    """Return the project of the working folder, with the settings of the command line.

    `add`: the paths are added to the project's sources instead of replacing them. `judged`: systems
    are among them, whatever the target makes.
    """
    with stages.stage("find definitions"):
        project = with_arguments(
            load(),
            paths=definitions.paths,
            include=definitions.include,
            define=definitions.define,
            ignore_case_clashes=definitions.ignore_case_clashes,
            prelude=definitions.prelude,
            encoding=definitions.encoding,
            output=output,
            add=add,
            node_id=node_id,
            target=target,
            judged=judged,
        )
        require_sources(project)
    return project
