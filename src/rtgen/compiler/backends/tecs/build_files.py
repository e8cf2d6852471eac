"""Generated files other than Python: build scripts, configuration, tecsgen's plug-in."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from rtgen.compiler.backends import Options
from rtgen.compiler.backends.kit.python_text import header, header_comment
from rtgen.compiler.backends.kit.rendering import render
from rtgen.compiler.layouts.signature_digest import DIGITS, SPELLINGS, signature_digest
from rtgen.compiler.lowering.tecs.options import NETWORK_WIDTHS, PC_OPTIONS, RtcOptions
from rtgen.compiler.lowering.tecs.plan import RtcJoin, TecsPackage


def _sources(package: TecsPackage) -> list[str]:
    return [source.key for source in package.sources]


def communication_conf(package: TecsPackage, join: RtcJoin, version: str) -> str:
    """Return the `.conf` of a join's communication RTC: both sets, and the active one."""
    options = join.options
    span = join.join.span
    index = "" if join.join.index is None else f"[{join.join.index}]"
    target = "::".join(join.join.target)
    shown = (
        f"{join.cell.scoped}.{join.join.port}{index} = {target}.{join.join.target_port}"
    )
    return render(
        "tecs/communication.conf.j2",
        active="mode1" if options.device else "mode2",
        header=header_comment(version, _sources(package)),
        join=shown,
        place=f"line {span.line}",
        signature=join.service.signature.scoped,
        device=options.device or "none",
        baudrate=options.baudrate,
        address=options.address,
        port=join.port,
        timeout=options.timeout,
    )


def tecsgen_plugin(
    package: TecsPackage, others: Iterable[TecsPackage], version: str
) -> str:
    """Return `RTCPlugin.rb`, by which tecsgen generates the board's half from the same CDL file.

    `others` are the project's packages: tecsgen also generates the joins of main files that this
    one imports.
    """
    files = {declaration.file for declaration in package.unit.declarations}
    parts = [package, *(p for p in others if p is not package and p.unit.file in files)]
    signatures = {s.signature.name: s.signature for p in parts for s in p.services}
    defaults = RtcOptions()
    return render(
        "tecs/RTCPlugin.rb.j2",
        header=header_comment(version, _sources(package)),
        ports=[(join.path, join.port) for part in parts for join in part.joins],
        digests=[
            (signature.scoped, signature_digest(package.unit, signature))
            for signature in signatures.values()
        ],
        digits=DIGITS,
        scalars=[(text, kind.value) for text, kind in SPELLINGS.items()],
        widths=NETWORK_WIDTHS.items(),
        dropped=PC_OPTIONS,
        allocator=defaults.limit,
        address=defaults.address,
    )


def build_scripts(package: TecsPackage, options: Options) -> dict[str, str]:
    """Return `build.sh` and `build.bat`; `options` are those of the package."""
    modules: Sequence[str] = [
        f"{options.package}.{service.module}_{part}"
        for service in package.services
        for part in ("marshaller", "server")
    ]
    values = {
        "package": options.package,
        "check": f"import {', '.join(modules)}",
        "idl": [f"{service.name}.idl" for service in package.services],
    }
    sources = _sources(package)
    return {
        "build.sh": render(
            "tecs/build.sh.j2",
            header=header_comment(options.version, sources),
            **values,
        ),
        "build.bat": render(
            "tecs/build.bat.j2", header=header(options.version, sources), **values
        ),
    }
