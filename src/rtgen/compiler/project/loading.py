"""The project as one validated value, from `rtgen.toml` and the command line."""

from __future__ import annotations

import keyword
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import msgspec
from msgspec.structs import replace

from rtgen.compiler.backends import Options
from rtgen.compiler.diagnostics import Diagnostic, InputError, Span
from rtgen.compiler.kit.project_file import FILE_NAME, find
from rtgen.compiler.lowering.settings import AdapterEntry, Settings
from rtgen.compiler.project.kinds import (
    SUFFIXES,
    is_definition,
    is_system,
    searched,
)
from rtgen.compiler.project.paths import (
    below,
    files,
    normal,
    shown,
    shown_path,
    tecs_path,
)
from rtgen.compiler.project.ros2 import Ros2Settings, ros2_settings
from rtgen.compiler.project.run_table import run_findings
from rtgen.compiler.project_rules import (
    NO_PATH,
    PATH_OVERLAP,
    PROJECT_NAME,
    SOURCE_KIND,
    SOURCE_NONE,
)
from rtgen.facts import python_modules
from rtgen.facts.adapter_constants import constants
from rtgen.facts.cdl_files import CDL_SUFFIXES
from rtgen.facts.file_names import is_device
from rtgen.facts.file_names import problem as path_problem
from rtgen.facts.files import is_folder
from rtgen.facts.idl_files import IDL_SUFFIXES
from rtgen.facts.numeric import Numeric
from rtgen.facts.version import __version__

if TYPE_CHECKING:
    from rtgen.compiler.frontends.stage import Settings as FrontendSettings
    from rtgen.compiler.project import file as project_file

TARGETS = ("embedded", "openrtm", "small", "typescript")
"""Where components can run."""

_SHOWN = 100
"""Maximum characters of a wrong path in a message."""

OUTPUT = "generated"
"""The output folder without `[output] dir`."""

SYSTEMS_TARGET = "openrtm"
"""The target that generates files for systems."""

PRELUDES = ("kernel", "none")
"""Declarations that CDL files can use without an import: TOPPERS' scalar types, or none."""


class Project(msgspec.Struct, frozen=True, kw_only=True):
    """The inputs and outputs of a run.

    `root` is the absolute folder of rtgen.toml (else the working folder), which the keys of inputs
    are relative to. `sources`, `systems` and `include` are displayed paths. `output` and
    `skeletons` are absolute, and must be below `base`. `tecs_path` are the folders of the
    environment's TECSPATH, which imports of CDL are searched for in last; `tecs_corba`: whether
    services of TECS boards can be called over CORBA. `node_id` is the node that devices are read
    for. `systems` are the RtsProfiles among the sources, which are not definitions.
    `ignored_in_files` has pattern, code and place of each entry of `[lint] per-file-ignores`; its
    patterns are relative to `root`. `encoding`, of `decoded_text.NAMES`, is that of sources that do
    not tell theirs. `problems` are doubts about rtgen.toml itself. `form` is `[fmt]`; `plugins` has
    the options of plug-ins, `[plugin.NAME]`; `templates` the displayed paths of those by name.
    """

    root: Path
    base: Path
    output: Path
    skeletons: Path
    file: Path | None = None
    sources: tuple[Path, ...] = ()
    systems: tuple[Path, ...] = ()
    include: tuple[Path, ...] = ()
    define: tuple[tuple[str, str], ...] = ()
    ignore_case_clashes: bool = False
    prelude: str = "kernel"
    encoding: str = "auto"
    tecs_path: tuple[Path, ...] = ()
    tecs_corba: bool = False
    package: str = "robots"
    target: str = "embedded"
    small: tuple[int, int, int] = (1024, 128, 2)
    representation: str = "cdr"
    extensibility: str = "final"
    numeric: Numeric = "array"
    components: tuple[tuple[str, str], ...] = ()
    adapters: tuple[AdapterEntry, ...] = ()
    ros2: Ros2Settings = Ros2Settings()
    form: Mapping[str, int] = msgspec.field(default_factory=dict)
    lint: tuple[tuple[str, str, Span], ...] = ()
    ignored_in_files: tuple[tuple[str, str, Span], ...] = ()
    plugins: Mapping[str, Mapping[str, Any]] = msgspec.field(default_factory=dict)
    templates: Mapping[str, Path] = msgspec.field(default_factory=dict)
    node_id: int | None = None
    problems: tuple[Diagnostic, ...] = ()

    @property
    def reading(self) -> FrontendSettings:
        """The settings of front ends."""
        from rtgen.compiler.frontends.stage import Settings as FrontendSettings

        return FrontendSettings(
            root=self.root,
            include=self.include,
            define=dict(self.define),
            ignore_case_clashes=self.ignore_case_clashes,
            tecs_path=self.tecs_path,
            encoding=self.encoding,
            prelude=self.prelude == "kernel",
            node_id=self.node_id,
            plugins=self.plugins,
            sources=tuple(self.sources),
        )

    @property
    def lowering(self) -> Settings:
        """The settings of lowerings."""
        idl = (path for path in self.sources if path.suffix.lower() in IDL_SUFFIXES)
        return Settings(
            adapters=self.adapters,
            definitions=frozenset(path.as_posix() for path in idl),
            numeric=self.numeric,
            extensibility=self.extensibility,
            representation=self.representation,
            plugins=self.plugins,
        )

    @property
    def options(self) -> Options:
        """The options of back ends."""
        return Options(
            package=self.package,
            skeleton_package=self.skeleton_package,
            version=__version__,
            target=self.target,
            small=self.small,
            representation=self.representation,
            extensibility=self.extensibility,
            tecs_corba=self.tecs_corba,
            ros_interfaces=self.ros2.interfaces,
            ros_boards=self.ros2.namespace if self.ros2.boards else None,
            ignore_case_clashes=self.ignore_case_clashes,
            factories=dict(self.components),
            skeleton_path=self.skeleton_path,
            plugins=self.plugins,
        )

    @property
    def emitted_systems(self) -> tuple[Path, ...]:
        """The systems, if files are generated for them."""
        return self.systems if self.target == SYSTEMS_TARGET else ()

    @property
    def skeleton_package(self) -> str:
        """The package that skeletons are imported from; empty for top-level modules in `src`."""
        return "" if self.skeletons.name == "src" else self.skeletons.name

    @property
    def ignored(self) -> dict[str, Span]:
        """The codes in `[lint] ignore`, with their places."""
        return {code: span for key, code, span in self.lint if key == "ignore"}

    @property
    def selected(self) -> dict[str, Span]:
        """The codes in `[lint] select`, with their places."""
        return {code: span for key, code, span in self.lint if key == "select"}

    @property
    def import_folders(self) -> tuple[Path, Path]:
        """The folders from which the generated package and the skeletons are importable."""
        skeletons = self.skeletons.parent if self.skeleton_package else self.skeletons
        return (self.output, skeletons)

    @property
    def skeleton_path(self) -> str:
        """The relative path from the output folder to the folder from which skeletons are
        imported.
        """
        output, skeletons = self.import_folders
        return Path(os.path.relpath(skeletons, output)).as_posix()


def load(start: Path | None = None) -> Project:
    """Load the project around the folder `start` (default: the working folder).

    Raises InputError if rtgen.toml is invalid. Without rtgen.toml: package `robots`, output folder
    `generated`, skeletons in `src`, no sources.
    """
    folder = (start or Path()).absolute()
    file = find(folder)
    if file is None:
        return Project(
            root=folder,
            base=folder,
            output=folder / OUTPUT,
            skeletons=folder / "src",
            tecs_path=tecs_path(),
        )
    from rtgen.compiler.project import file as project_file

    settings = project_file.read(file, shown(file))
    root = file.parent
    project = Project(
        root=root,
        base=root,
        output=normal(root / settings.text("output", "dir", OUTPUT)),
        skeletons=normal(root / settings.text("output", "skeletons", "src")),
        file=file,
        include=tuple(
            shown_path(root / p) for p in settings.texts("sources", "include")
        ),
        define=tuple(sorted(settings.macros().items())),
        ignore_case_clashes=_ignores_case(settings),
        prelude=settings.text("sources", "prelude", "kernel"),
        encoding=settings.text(
            "sources", "encoding", settings.text("sources", "kcode", "auto")
        ),
        problems=settings.problems,
        tecs_path=tecs_path(),
        tecs_corba=settings.flag("tecs", "corba"),
        package=settings.text("output", "package", "robots"),
        target=settings.text("output", "target", "embedded"),
        small=(
            settings.number("small", "sequence", 1024),
            settings.number("small", "string", 128),
            settings.number("small", "buffer", 2),
        ),
        representation=settings.text("output", "representation", "cdr"),
        extensibility=settings.text("output", "extensibility", "final"),
        numeric=cast("Numeric", settings.text("python", "numeric", "array")),
        components=tuple(sorted(settings.table("components").items())),
        ros2=ros2_settings(settings),
        adapters=tuple(
            AdapterEntry(
                name=name,
                source=table["from"],
                target=table["to"],
                mapping=tuple(table.get("map", {}).items()),
                span=settings.span("adapter", name),
                constants=tuple(constants(table.get("set", {})).items()),
                units={
                    p: (sent, made)
                    for p, (sent, made) in table.get("units", {}).items()
                },
            )
            for name, table in settings.tables("adapter").items()
        ),
        form=settings.content.get("fmt", {}),
        lint=tuple(
            (key, code, settings.span("lint", key, code))
            for key in ("ignore", "select")
            for code in settings.texts("lint", key)
        ),
        ignored_in_files=tuple(
            (pattern, code.upper(), settings.span("lint", "per-file-ignores", code))
            for pattern, codes in settings.tables("lint")
            .get("per-file-ignores", {})
            .items()
            for code in codes
        ),
        plugins=settings.tables("plugin"),
    )
    findings = [
        *settings.check_paths(root),
        *run_findings(settings, root),
        *_check_names(project, settings),
        *_check_folders(project, settings),
    ]
    if "templates" in settings.content:
        from rtgen.compiler.project.templates import templates_of

        templates, faults = templates_of(settings, root, project.output)
        project, findings = replace(project, templates=templates), findings + faults
    if findings:
        raise InputError(findings)
    paths = [shown_path(root / p) for p in settings.texts("sources", "paths")]
    return _with_files(project, paths)


def with_arguments(
    project: Project,
    *,
    paths: Sequence[str] = (),
    include: Sequence[str] = (),
    define: Sequence[tuple[str, str]] = (),
    ignore_case_clashes: bool = False,
    prelude: str | None = None,
    encoding: str | None = None,
    output: str | None = None,
    add: bool = False,
    node_id: int | None = None,
    target: str | None = None,
    judged: bool = False,
) -> Project:
    """Return the project as changed by the command line's arguments.

    `add`: the paths are added to the sources of rtgen.toml instead of replacing them; otherwise the
    project's adapters are dropped, since their types may be missing. Systems alone are read with
    the definitions and adapters of rtgen.toml. `judged`: nothing is made of the paths, so a system
    is one of them for every target. Raises InputError for a path that is not a definition file.
    """
    changes = project
    _require_possible([*paths, *include, output or ""])
    if output is not None:
        base = normal(Path(output).absolute())
        skeletons = base / "src"
        if project.skeleton_package:
            skeletons /= project.skeleton_package
        changes = replace(changes, base=base, output=base / OUTPUT, skeletons=skeletons)
    if paths:
        named = [Path(p) for p in paths]
        maker = SYSTEMS_TARGET if judged else target or project.target
        findings = [f for p in named if (f := _check_kind(p, maker)) is not None]
        findings += _without_definitions(named, changes.output)
        if findings:
            raise InputError(findings)
        before = [*project.sources, *project.systems] if add else []
        changes = _with_files(changes, [*before, *named])
        if changes.systems and not changes.sources:
            changes = replace(changes, sources=project.sources)
        elif not add:
            changes = replace(changes, adapters=())
    return replace(
        changes,
        include=(*(Path(p) for p in include), *project.include),
        define=tuple(sorted({**dict(project.define), **dict(define)}.items())),
        ignore_case_clashes=project.ignore_case_clashes or ignore_case_clashes,
        prelude=prelude or project.prelude,
        encoding=encoding or project.encoding,
        node_id=node_id,
        target=target or project.target,
    )


def _ignores_case(settings: project_file.Settings) -> bool:
    """Return whether names of IDL may differ in case only, as those of DDS and ROS 2 do."""
    case = settings.text("idl", "case", "")
    return case == "dds" if case else settings.flag("sources", "ignore_case_clashes")


def _with_files(project: Project, paths: Iterable[Path]) -> Project:
    """Return the project with these files and folders as its sources."""
    definitions = list(files(paths, skip=project.output))
    _require_possible(definitions)
    systems = [path for path in definitions if is_system(path)]
    sources = [path for path in definitions if path not in systems]
    return replace(project, sources=tuple(sources), systems=tuple(systems))


def _require_possible(paths: Iterable[Path | str]) -> None:
    """Raise InputError for paths that no file has, or that generated files cannot name."""
    findings = [f for path in paths if (f := path_finding(str(path))) is not None]
    if findings:
        raise InputError(findings)


def path_finding(path: str) -> Diagnostic | None:
    """Return the diagnostic for a path that no file has; None for others."""
    problem = path_problem(path)
    if problem is None:
        return None
    return NO_PATH.at(None, f"{path[:_SHOWN]!r} {problem}", hint="rename it")


def require_sources(project: Project) -> None:
    """Raise InputError if there is nothing to read."""
    if project.sources:
        return
    if project.file is None:
        message = (
            f"no {FILE_NAME} here or in a folder above, and no definition file given"
        )
        hint = f"name definition files, or write a {FILE_NAME} with [sources] paths"
    else:
        message = f"{shown(project.file)}: [sources] paths names no definition files"
        hint = f'paths = ["FOLDER"]; {searched()}'
    raise InputError([SOURCE_NONE.at(None, message, hint=hint)])


def _without_definitions(paths: Iterable[Path], output: Path) -> Iterator[Diagnostic]:
    """Yield diagnostics for folders in which there is nothing to read."""
    for path in paths:
        if is_folder(path) and not below(path, output):
            message = f"no definition file is in the folder {path.as_posix()}"
            yield SOURCE_NONE.at(None, message, hint=searched())


def load_around(path: Path) -> Project:
    """Load the project of the working folder; if that has no rtgen.toml, the one around `path`.

    Raises InputError if rtgen.toml is invalid.
    """
    project = load()
    if project.file is not None:
        return project
    other = load(path if path.is_dir() else path.parent)
    return project if other.file is None else other


def _check_kind(path: Path, target: str) -> Diagnostic | None:
    if target != SYSTEMS_TARGET and is_system(path):
        message = f"{path.as_posix()} is a system, of which {target!r} makes nothing"
        hint = f"--target {SYSTEMS_TARGET}; or rtgen run, rtgen graph"
        return SOURCE_KIND.at(None, message, hint=hint)
    if is_folder(path) or is_definition(path):
        return None
    if path.suffix.lower() == ".toml" and path.name != FILE_NAME:
        return None  # given as a bus file: its reader reports errors
    if path.suffix.lower() in CDL_SUFFIXES:
        return None  # also a *.cde, for which no folder is searched
    if path.suffix.lower() == ".xpd":
        hint = "an XPD is a profile for editors (CiA 311): call that of a device *.xdd"
    elif path.suffix.lower() == ".xml":
        hint = (
            "XML is read if it is a profile of OpenRTM or of a robot system: RtcProfile or "
            "RtsProfile is its root element"
        )
    else:
        kinds = ", ".join(f"*{s}" for s in (*SUFFIXES, ".toml", ".xml"))
        hint = f"rtgen reads {kinds}"
    return SOURCE_KIND.at(
        None, f"{path.as_posix()} is not a definition file", hint=hint
    )


def _check_names(
    project: Project, settings: project_file.Settings
) -> Iterator[Diagnostic]:
    root = project.package.partition(".")[0]
    names = [("package", "package", project.package.split("."))]
    if project.skeleton_package:
        names.append(("skeletons", "skeleton folder", [project.skeleton_package]))
    for key, what, parts in names:
        where = settings.span("output", key)
        owner = python_modules.owner(parts[0])
        if not all(map(_is_module, parts)):
            message = f"{what} {'.'.join(parts)!r} is not a Python identifier"
            yield PROJECT_NAME.at(where, message)
        elif device := next(filter(is_device, parts), None):
            message = (
                f"{what} {device!r}: Windows takes a file of this name for a device"
            )
            yield PROJECT_NAME.at(where, message)
        elif parts[0] == "generated" or owner:
            yield PROJECT_NAME.at(
                where,
                f"a package called {parts[0]!r} would hide that of {owner or 'others'}",
                hint="choose a name of your own, such as 'robots'",
            )
        elif key == "skeletons" and parts[0] == root:
            yield PROJECT_NAME.at(
                where,
                f"the skeletons' package and the generated one are both called {root!r}",
            )


def _is_module(name: str) -> bool:
    """Return whether an import statement can name a module."""
    return name.isascii() and name.isidentifier() and not keyword.iskeyword(name)


def _check_folders(
    project: Project, settings: project_file.Settings
) -> Iterator[Diagnostic]:
    for key, folder in (("dir", project.output), ("skeletons", project.skeletons)):
        if not folder.is_relative_to(project.root) or folder == project.root:
            yield PATH_OVERLAP.at(
                settings.span("output", key),
                f"the folder {key!r} must lie below the folder of {FILE_NAME}",
            )
    sources = [normal(project.root / p) for p in settings.texts("sources", "paths")]
    for other, what in (
        (project.skeletons, "skeletons"),
        *((s, "sources") for s in sources),
    ):
        if other.is_relative_to(project.output):
            yield PATH_OVERLAP.at(
                settings.span("output", "dir"),
                f"the output folder holds the {what}: {shown(other)}",
                hint="rtgen owns its output folder; keep your own files outside it",
            )
