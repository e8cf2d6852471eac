"""All front ends with the suffixes of their files: the built-in ones, then plug-ins."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Protocol, TypeAlias

import msgspec
from msgspec.structs import replace

from rtgen.compiler.diagnostics import Diagnostic
from rtgen.compiler.frontends import Dependency, FrontendResult, together
from rtgen.compiler.frontends.kit.library import VirtualFile, absolute_path
from rtgen.compiler.kit import plugins, stages
from rtgen.compiler.model import Model
from rtgen.facts.cdl_files import CDL_SUFFIXES
from rtgen.facts.device_files import DEVICE_SUFFIXES
from rtgen.facts.files import read_start
from rtgen.facts.idl_files import IDL_SUFFIXES
from rtgen.facts.ros import GENERATED_IDL, INTERFACE_KINDS, INTERFACE_SUFFIXES

if TYPE_CHECKING:
    from rtgen.compiler.frontends.cdl.names.table import Table
    from rtgen.compiler.frontends.cdl.syntax.unit import Unit as CdlUnit
    from rtgen.compiler.frontends.idl.pipeline import Observer as IdlObserver
    from rtgen.compiler.frontends.idl.text.source import Interfaces
    from rtgen.compiler.frontends.kit.memo import Memo


class Observer(Protocol):
    """Observer of names and symbols, which are not part of the model."""

    @property
    def idl(self) -> IdlObserver:
        """The observer of IDL translation units."""

    def cdl(self, table: Table, units: Sequence[CdlUnit]) -> None:
        """Called with the symbols of a CDL unit, and its files."""


class Settings(msgspec.Struct, frozen=True, kw_only=True):
    """The settings of all front ends.

    `root` is the project's folder, to which keys of files are relative. `include` are the folders
    of `#include` and `import`, `tecs_path` those searched for imports of CDL after them; `define`
    are macros. `encoding`, of `decoded_text.NAMES`, is that of files that do not tell theirs; with
    `prelude` the scalar types of TOPPERS kernels are known in CDL. `node_id` is the node that
    devices are read for. `plugins` has the table `[plugin.NAME]` of rtgen.toml for each name.
    `sources` are all files of the project. `observer` is given the resolved names. `memo` caches
    the results of earlier runs, which are used if no file has changed.
    """

    root: Path
    include: tuple[Path, ...] = ()
    define: Mapping[str, str] = msgspec.field(default_factory=dict)
    ignore_case_clashes: bool = False
    tecs_path: tuple[Path, ...] = ()
    encoding: str = "auto"
    prelude: bool = True
    node_id: int | None = None
    plugins: Mapping[str, Mapping[str, Any]] = msgspec.field(default_factory=dict)
    sources: tuple[Path, ...] = ()
    observer: Observer | None = None
    memo: Memo | None = None


Read: TypeAlias = Callable[[Sequence[Path], Settings], FrontendResult]


def _each(
    paths: Sequence[Path],
    settings: Settings,
    load: Callable[[Path], FrontendResult],
    *options: Hashable,
    fits: Callable[[FrontendResult], bool] = lambda _: True,
) -> FrontendResult:
    """Read files that do not depend on each other, one at a time.

    A result depends on the files that it lists, and on `options`; it is cached if it `fits`.
    """
    distinct: dict[str, Path] = {}
    for path in paths:
        distinct.setdefault(absolute_path(path), path)
    results = []
    for path in distinct.values():
        if settings.memo is None:
            results.append(load(path))
            continue
        key = (load.__qualname__, str(Path.cwd()), settings.root, path, *options)
        results.append(settings.memo.read(key, partial(load, path), fits))
    return together(results)


def _is_found(result: FrontendResult) -> bool:
    """Return whether no file is missing: a hint about one may depend on its folder's content."""
    return all(each.sha256 is not None for each in result.dependencies)


def _profiles(paths: Sequence[Path], settings: Settings) -> FrontendResult:
    from rtgen.compiler.frontends.profiles import rtc_profile
    from rtgen.compiler.frontends.profiles.rtc_profile.idl_search import candidates

    def profile(path: Path) -> FrontendResult:
        return rtc_profile.load(
            [path],
            root=settings.root,
            include=settings.include,
            encoding=settings.encoding,
            sources_of_types=settings.sources,
        )

    searched: tuple[Path, ...] = ()
    if settings.memo is not None:
        places = settings.root, settings.include, settings.sources
        searched = tuple(each for path in paths for each in candidates(path, *places))
    options = settings.include, settings.encoding, searched
    return _each(paths, settings, profile, *options)


def _devices(paths: Sequence[Path], settings: Settings) -> FrontendResult:
    from rtgen.compiler.frontends import eds

    def device(path: Path) -> FrontendResult:
        return eds.load(
            [path],
            root=settings.root,
            node_id=settings.node_id,
            encoding=settings.encoding,
        )

    options = (settings.node_id, settings.encoding)
    return _each(paths, settings, device, *options, fits=_is_found)


def _buses(paths: Sequence[Path], settings: Settings) -> FrontendResult:
    from rtgen.compiler.frontends import bus

    def network(path: Path) -> FrontendResult:
        stages.file(path.as_posix())
        result = bus.load(path, root=settings.root, encoding=settings.encoding)
        return FrontendResult(
            Model(buses=() if result.bus is None else (result.bus,)),
            result.diagnostics,
            result.sources,
            result.dependencies,
        )

    return _each(paths, settings, network, settings.encoding, fits=_is_found)


def _boards(paths: Sequence[Path], settings: Settings) -> FrontendResult:
    from rtgen.compiler.frontends import cdl

    return cdl.load(
        paths,
        root=settings.root,
        include=(*settings.include, *settings.tecs_path),
        define=settings.define,
        encoding=settings.encoding,
        prelude=settings.prelude,
        observe=None if settings.observer is None else settings.observer.cdl,
        memo=settings.memo,
    )


def _of_wing(module: str) -> Read:
    """Return the reader of a wing above the compiler: `read` of a module, imported at first use."""

    def read(paths: Sequence[Path], settings: Settings) -> FrontendResult:
        reader: Read = import_module(module).read
        return reader(paths, settings)

    return read


FRONTENDS: Final[tuple[tuple[str, tuple[str, ...], Read], ...]] = (
    ("profiles", (".xml", ".yaml", ".yml"), _profiles),
    ("device descriptions", DEVICE_SUFFIXES, _devices),
    ("bus files", (".toml",), _buses),
    ("CDL", CDL_SUFFIXES, _boards),
    ("ROS 2 interfaces", INTERFACE_SUFFIXES, _of_wing("rtgen.ros2.rosidl")),
)
"""The front ends, with the suffixes of their files.

Without that of IDL, which is last: other definitions refer to IDL files.
"""


def read(paths: Sequence[Path], settings: Settings) -> Iterator[FrontendResult]:
    """Yield the result of each front end except IDL's. Raises ToolError for a plug-in."""
    for name, suffixes, load in FRONTENDS:
        chosen = ending_with(paths, suffixes)
        if suffixes is INTERFACE_SUFFIXES:
            chosen += filter(_is_of_ros2, ending_with(paths, IDL_SUFFIXES))
        if chosen:
            with stages.stage(f"read {name}"):
                result = load(chosen, settings)
            yield result
    for name, frontend in plugins.loaded(plugins.Group.FRONTENDS):
        if chosen := ending_with(paths, plugins.suffixes(name, frontend)):
            with stages.stage(f"read {name}"):
                result = _by_plugin(name, frontend, chosen, settings)
            yield result


def _by_plugin(
    name: str, frontend: Any, paths: Sequence[Path], settings: Settings
) -> FrontendResult:
    """Return the checked result of a plug-in's front end. Raises ToolError."""
    with plugins.running(plugins.Group.FRONTENDS, name):
        result = frontend.load(
            paths,
            root=settings.root,
            include=settings.include,
            options=settings.plugins.get(name, {}),
        )
        read = plugins.require(FrontendResult, result)
        return FrontendResult(
            plugins.require(Model, read.model),
            plugins.require_each(Diagnostic, read.diagnostics),
            dict(read.sources),
            plugins.require_each(Dependency, read.dependencies),
            plugins.require_each(Path, read.idl),
        )


def read_idl(
    paths: Sequence[Path],
    settings: Settings,
    *,
    text: VirtualFile | None = None,
    named: Sequence[Path] = (),
    needed: Sequence[str] = (),
    printed: Mapping[str, Callable[[], str]] | None = None,
    interfaces: Interfaces | None = None,
) -> FrontendResult:
    """Read the IDL files of the paths, a `text`, and files required by other definitions.

    `named` are files, `needed` names of IDL files that ship with rtgen. `printed` are texts of IDL
    files that exist only when they are included, by name; `interfaces` returns that of a file that
    ROS 2 has generated.
    """
    own = (p for p in ending_with(paths, IDL_SUFFIXES) if not _is_of_ros2(p))
    chosen = (*own, *named)
    if not chosen and not needed and text is None:
        return together(())
    from rtgen.compiler.frontends import idl
    from rtgen.compiler.frontends.idl import library

    virtual = {
        **library.shipped(chosen, needed),
        **{name: VirtualFile(name, make) for name, make in (printed or {}).items()},
        **({} if text is None else {text.key: text}),
    }
    with stages.stage("read IDL"):
        result = idl.load(
            chosen,
            root=settings.root,
            include=settings.include,
            define=settings.define,
            ignore_case_clashes=settings.ignore_case_clashes,
            virtual=virtual,
            observer=None if settings.observer is None else settings.observer.idl,
            memo=settings.memo,
            encoding=settings.encoding,
            interfaces=interfaces,
        )
    shipped = library.dependencies(result.model.files)
    return replace(result, dependencies=(*result.dependencies, *shipped))


def _is_of_ros2(idl: Path) -> bool:
    """Return whether an IDL file is an interface of ROS 2 in the form that it generates."""
    if idl.absolute().parent.name not in INTERFACE_KINDS.values():
        return False
    try:
        return read_start(idl, len(GENERATED_IDL)) == GENERATED_IDL
    except OSError:
        return False


def ending_with(paths: Sequence[Path], suffixes: Sequence[str]) -> list[Path]:
    """Return the paths with one of the suffixes, ignoring case."""
    return [path for path in paths if path.suffix.lower() in suffixes]
