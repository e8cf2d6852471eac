"""The files of networks: the module, a DCF for each node, start-up and timing as reports."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import PurePosixPath

from msgspec.structs import replace

from rtgen.compiler.backends import Artifact, Options
from rtgen.compiler.backends.canopen.eds_text import eds_text
from rtgen.compiler.backends.canopen.network_module import network_module
from rtgen.compiler.backends.canopen.reports import start_up_text, timing_text
from rtgen.compiler.backends.canopen.rules import NOT_WRITABLE
from rtgen.compiler.backends.kit.python_text import header, header_comment
from rtgen.compiler.diagnostics import Diagnostic
from rtgen.compiler.layouts.can_startup import concise_dcf, start_up
from rtgen.compiler.layouts.can_values import CanValueError
from rtgen.compiler.model.can_bus import Bus, BusNode
from rtgen.compiler.model.canopen import Commissioning, DataType, Device

_CONCISE_DCF = 0x1F22


def network_files(
    buses: Sequence[Bus], options: Options
) -> tuple[list[Artifact], list[Diagnostic]]:
    """Return all files of all networks, and diagnostics."""
    findings = []
    for bus in buses:
        for node in bus.nodes:
            try:
                start_up(node)
            except CanValueError as error:
                findings.append(NOT_WRITABLE.at(node.span, f"{node.name}: {error}"))
    if findings or not buses:
        return [], findings
    return list(_artifacts(buses, options)), []


def _artifacts(buses: Sequence[Bus], options: Options) -> Iterator[Artifact]:
    folder = f"{options.folder}/canopen/networks"
    keys = tuple(dict.fromkeys(bus.key for bus in buses))
    comment = header_comment(options.version, keys)
    yield Artifact(f"{folder}/__init__.py", f'{comment}"""CANopen networks."""\n', keys)
    for bus in buses:
        name = bus.name
        devices = (node.device.key for node in bus.nodes)
        origin = tuple(dict.fromkeys((bus.key, *devices)))
        lines = header(options.version, origin)
        yield network_module(f"{folder}/{name}.py", bus, origin, options)
        for node in bus.nodes if bus.dcf else ():
            dcf = eds_text(configured(bus, node), lines)
            yield Artifact(f"{folder}/{name}/{node.name}.dcf", dcf, origin)
        report = start_up_text(bus, lines)
        yield Artifact(f"{folder}/{name}_start_up.txt", report, origin)
        yield Artifact(f"{folder}/{name}_timing.txt", timing_text(bus, lines), origin)


def configured(bus: Bus, node: BusNode) -> Device:
    """Return a node's device with its settings on the bus.

    A device with object 1F22h (concise DCF) contains the configurations of the other nodes.
    """
    device = node.device
    commissioning = device.commissioning or Commissioning()
    objects = tuple(
        (
            replace(
                thing,
                variables=tuple(
                    (
                        replace(variable, value=concise[variable.subindex])
                        if variable.subindex in concise
                        and variable.data_type == DataType.DOMAIN
                        else variable
                    )
                    for variable in thing.variables
                ),
            )
            if thing.index == _CONCISE_DCF and (concise := _concise(bus, node))
            else thing
        )
        for thing in device.objects
    )
    return replace(
        device,
        objects=objects,
        commissioning=replace(
            commissioning,
            node_id=node.id,
            node_name=node.name,
            bit_rate=bus.bit_rate,
            network_name=bus.name,
        ),
        file_info=replace(
            device.file_info,
            file_name=f"{node.name}.dcf",
            last_eds=PurePosixPath(node.kind.path).name,
        ),
    )


def _concise(bus: Bus, keeper: BusNode) -> dict[int, bytes]:
    """Return the configurations of the other nodes, by node-id."""
    return {
        node.id: concise_dcf(start_up(node)) for node in bus.nodes if node is not keeper
    }
