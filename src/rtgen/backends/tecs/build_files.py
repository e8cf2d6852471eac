"""What is no Python: build scripts, configuration files, the plug-in for real tecsgen."""

from __future__ import annotations

from collections.abc import Sequence

from rtgen.backends.python_text import comment_text, header, header_comment
from rtgen.backends.rendering import render
from rtgen.backends.tecs.options import FIRST_PORT, PC_OPTIONS, RtcOptions
from rtgen.backends.tecs.plan import RtcJoin, TecsPackage


def _sources(package: TecsPackage) -> list[tuple[str, str]]:
    return [(source.key, source.sha256) for source in package.sources]


def communication_conf(package: TecsPackage, join: RtcJoin, version: str) -> str:
    """The `.conf` of a join's communication RTC: both sets, and which one is active."""
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
        header=header(version, _sources(package)),
        join=comment_text(shown),
        place=f"line {span.line}",
        signature=join.service.signature.scoped,
        device=options.device or "none",
        baudrate=options.baudrate,
        address=options.address,
        port=join.port,
        timeout=options.timeout,
    )


def tecsgen_plugin(package: TecsPackage, version: str) -> str:
    """`RTCPlugin.rb`: the same CDL file makes the board's half with real tecsgen."""
    defaults = RtcOptions()
    return render(
        "tecs/RTCPlugin.rb.j2",
        header=header_comment(version, _sources(package)),
        dropped=PC_OPTIONS,
        allocator=defaults.limit,
        first_port=FIRST_PORT,
        address=defaults.address,
    )


def build_scripts(package: TecsPackage, version: str) -> dict[str, str]:
    """`build.sh` and `build.bat`."""
    modules: Sequence[str] = [
        f"{package.package}.{service.module}_{part}"
        for service in package.services
        for part in ("marshaller", "server")
    ]
    values = {
        "package": package.package,
        "check": f"import {', '.join(modules)}",
        "idl": " ".join(f"{service.name}.idl" for service in package.services),
    }
    sources = _sources(package)
    return {
        "build.sh": render(
            "tecs/build.sh.j2", header=header_comment(version, sources), **values
        ),
        "build.bat": render(
            "tecs/build.bat.j2", header=header(version, sources), **values
        ),
    }
