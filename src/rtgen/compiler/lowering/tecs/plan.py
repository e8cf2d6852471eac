"""The plan of TECS lowering: packages of CDL files, their services, joins with their options."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from pathlib import PurePosixPath

import msgspec

from rtgen.compiler.diagnostics import Diagnostic, Related, Span, has_errors
from rtgen.compiler.lowering.tecs.options import RtcOptions, read_options
from rtgen.compiler.lowering.tecs.rules import (
    BAD_OPTION,
    DIFFERENT_OPTIONS,
    SAME_CHANNEL,
    SAME_COMPONENT,
    SAME_NAME,
)
from rtgen.compiler.model import Model, ScopedName, SourceFile
from rtgen.compiler.model.tecs import Cell, Join, Signature, TecsUnit, Through
from rtgen.compiler.typemap.python.names import identifier, module_name
from rtgen.compiler.typemap.tecs.python import plain_name
from rtgen.facts.opaque_rpc import FIRST_PORT

PLUGIN = "RTCPlugin"
FOLDER = "tecs"
"""The package of code generated for CDL files, below the project's own."""


class Service(msgspec.Struct, frozen=True):
    """A signature with RTCs: `name` as in `ServerMarshaller`, `module` as in `server_codec`.

    `options` are common to all its joins.
    """

    signature: Signature
    name: str
    module: str
    options: RtcOptions


class RtcJoin(msgspec.Struct, frozen=True):
    """A join through `RTCPlugin`. `number` counts in the CDL file, from 0."""

    number: int
    cell: Cell
    join: Join
    through: Through
    service: Service
    options: RtcOptions

    @property
    def instance(self) -> str:
        """The instance name of the join's communication RTC."""
        return self.options.name or f"OpaqueRpcCommunication{self.number}"

    @property
    def port(self) -> int:
        """The board's TCP port."""
        return self.options.port or FIRST_PORT + self.number

    @property
    def channel(self) -> str:
        """The board's serial line, else its TCP address."""
        options = self.options
        return options.device or f"{options.address}:{self.port}"

    @property
    def path(self) -> str:
        """The key of the join in `RTCPlugin.rb`: its call port.

        The key of a region's plug-in is its region and the target, since callers share it.
        """
        join, through = self.join, self.through
        if through.origin == "through":
            return f"{self.cell.scoped}.{join.port}{_subscript(join.index)}"
        target = f"{'::'.join(join.target)}.{join.target_port}"
        region = "::".join(through.region)
        return f"{through.origin} {region} {target}{_subscript(join.target_index)}"


class TecsPackage(msgspec.Struct, frozen=True):
    """The package of a CDL file. `sources` are its inputs, the main file first."""

    unit: TecsUnit
    stem: str
    sources: tuple[SourceFile, ...]
    services: tuple[Service, ...]
    joins: tuple[RtcJoin, ...]

    @property
    def name(self) -> str:
        """The Python package, below the project's own."""
        return f"{FOLDER}.{self.stem}"

    @property
    def origin(self) -> tuple[str, ...]:
        """The keys of the sources."""
        return tuple(source.key for source in self.sources)


def packages(model: Model) -> tuple[list[TecsPackage], list[Diagnostic]]:
    """Return the packages in the order of the CDL files, and diagnostics."""
    planned: list[TecsPackage] = []
    findings: list[Diagnostic] = []
    mains = {unit.file for unit in model.tecs}
    for unit in model.tecs:
        planner = _Planner(model, unit, mains - {unit.file})
        package = planner.package()
        findings += planner.findings
        if package is not None:
            planned.append(package)
    findings += _same_components(planned)
    return planned, findings


class _Planner:
    def __init__(self, model: Model, unit: TecsUnit, others: set[str]) -> None:
        self._model = model
        self._unit = unit
        self._others = others
        self.findings: list[Diagnostic] = []

    def package(self) -> TecsPackage | None:
        """Return the package; None without a join of this main file.

        Joins of an imported main file belong to that file.
        """
        joined = _distinct(
            (cell, join, through)
            for cell, join in self._unit.joins_through(PLUGIN)
            if cell.file not in self._others
            for through in join.through
            if through.plugin == PLUGIN
        )
        services: dict[ScopedName, Service] = {}
        joins: list[RtcJoin] = []
        for number, (cell, join, through) in enumerate(joined):
            options, diagnostics = read_options(through)
            self.findings += diagnostics
            signature = self._signature(join)
            service = services.setdefault(signature.name, _service(signature, options))
            rtc_join = RtcJoin(number, cell, join, through, service, options)
            if not diagnostics:
                self.findings += _compared(rtc_join, joins)
            joins.append(rtc_join)
        if not joins:
            return None
        self.findings += _same_names(services.values())
        if not has_errors(self.findings):
            self.findings += _same_channels(joins)
        stem = PurePosixPath(self._unit.file).stem
        return TecsPackage(
            unit=self._unit,
            stem=identifier(stem),
            sources=self._sources(joins),
            services=tuple(services.values()),
            joins=tuple(joins),
        )

    def _signature(self, join: Join) -> Signature:
        signature = self._unit.find(join.signature, Signature)
        assert isinstance(signature, Signature)
        return signature

    def _sources(self, joins: Iterable[RtcJoin]) -> tuple[SourceFile, ...]:
        """Return the main file, and the files of the signatures and joins."""
        names = [self._unit.file]
        for join in joins:
            names += [join.service.signature.file, join.cell.file]
        by_name = {file.name: file for file in self._model.files}
        return tuple(by_name[name] for name in dict.fromkeys(names) if name in by_name)


def _compared(join: RtcJoin, others: Sequence[RtcJoin]) -> Iterator[Diagnostic]:
    """Yield the options that differ from those of earlier joins."""
    for other in others:
        same = other.service is join.service
        shared = ("file", "signature") if same else ("file",)
        differing = join.options.differing(other.options, *shared)
        if differing:
            yield DIFFERENT_OPTIONS.at(
                join.through.span,
                f"this join and another one differ in {', '.join(differing)}",
                related=[Related(other.through.span, "the other is here")],
                hint="describe boards that differ in CDL files of their own",
            )
            return


def _same_names(services: Iterable[Service]) -> Iterator[Diagnostic]:
    seen: dict[str, Service] = {}
    for service in services:
        other = seen.setdefault(service.module, service)
        if other is not service:
            yield SAME_NAME.at(
                service.signature.span,
                f"{service.signature.scoped} and {other.signature.scoped} "
                f"both become {service.name}",
                related=[Related(other.signature.span, "the other is here")],
                hint="rename one of them",
            )


def _same_channels(joins: Iterable[RtcJoin]) -> Iterator[Diagnostic]:
    """Yield the joins whose calls go to the server of another one, or nowhere."""
    channels: dict[str, RtcJoin] = {}
    instances: dict[str, RtcJoin] = {}
    paths: dict[str, RtcJoin] = {}
    for join in joins:
        place = join.through.span
        other = instances.setdefault(join.instance, join)
        if other is not join:
            yield BAD_OPTION.at(
                place,
                f"name cannot be {join.instance!r}: another join has it",
                related=[Related(other.through.span, "the other is here")],
                hint="give the RTC of each join a name of its own",
            )
        other = paths.setdefault(join.path, join)
        if other is not join:
            yield SAME_CHANNEL.at(
                place,
                f"{join.path} goes through {PLUGIN} twice",
                related=[Related(other.through.span, "the other is here")],
                hint="leave out one of them",
            )
            continue
        other = channels.setdefault(join.channel, join)
        if other is not join:
            yield SAME_CHANNEL.at(
                place,
                f"{join.channel} is the channel of {other.path}, too",
                related=[Related(other.through.span, "the other is here")],
            )


def _distinct(
    joined: Iterable[tuple[Cell, Join, Through]],
) -> Iterator[tuple[Cell, Join, Through]]:
    """Yield the joins, one for each channel.

    A region's plug-in makes one cell for all its callers of one entry port.
    """
    seen = set()
    for cell, join, through in joined:
        target = (join.target, join.target_port, join.target_index)
        key = (through.span, through.origin, target)
        if through.origin == "through" or key not in seen:
            seen.add(key)
            yield cell, join, through


def _subscript(index: int | None) -> str:
    return "" if index is None else f"[{index}]"


def _service(signature: Signature, options: RtcOptions) -> Service:
    name = plain_name(signature)
    return Service(signature, name, module_name(name), options)


def _same_components(planned: Sequence[TecsPackage]) -> Iterator[Diagnostic]:
    seen: dict[str, TecsPackage] = {}
    for package in planned:
        for service in package.services:
            other = seen.setdefault(service.name, package)
            if other is not package:
                yield SAME_COMPONENT.at(
                    next(j.through.span for j in package.joins if j.service is service),
                    f"{service.name}Marshaller is a component type of "
                    f"{other.unit.file}, too",
                    related=[Related(_place(other), "the first is here")],
                    hint="name the one that is meant in [components] of rtgen.toml",
                )


def _place(package: TecsPackage) -> Span:
    return package.joins[0].through.span
