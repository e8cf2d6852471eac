"""Plug-ins by name: rtgen's own, those that tecsgen ships, and suggestions for others."""

from __future__ import annotations

from dataclasses import dataclass, field

from rtgen.compiler.kit.words import words

OURS = frozenset({"RTCPlugin", "RTCPlug-in"})
"""The names of rtgen's plug-in; the second is the spelling of the paper."""

OWN_NAME = "RTCPlugin"

_SUFFIX = "plugin"

THROUGH = words("""
    HRP2RPCPlugin HRP2SVCPlugin HRPRPCPlugin HRPSVCThroughPlugin OpaqueRPCPlugin RPCPlugin
    RepeatJoinPlugin SharedOpaqueRPCPlugin SharedRPCPlugin ThroughPlugin TracePlugin
    """)
"""Plug-ins of joins and regions that tecsgen ships."""

GENERATE = words("""
    ATK1AlarmPlugin ATK1DelayTaskPlugin ATK1EventPlugin ATK1ISRPlugin ATK1KernelPlugin
    ATK1ResourcePlugin ATK1TaskPlugin C2TECSBridgePlugin CIfGenCellPlugin CIfGenCelltypePlugin
    CIfGenPlugin CellPlugin CelltypePlugin CompositePlugin CppIfGenCellPlugin CppIfGenCelltypePlugin
    CppIfGenPlugin FMPHandlerPlugin FMPObjectPlugin FMPPlugin HRMPKernelObjectPlugin
    HRP2AlarmHandlerPlugin HRP2CyclicHandlerPlugin HRP2DataqueuePlugin HRP2EventflagPlugin
    HRP2FixedSizeMemoryPoolPlugin HRP2HandlerPlugin HRP2KernelObjectPlugin HRP2ObjectPlugin
    HRP2PriorityDataqueuePlugin HRP2SemaphorePlugin HRP2TaskPlugin HRPHandlerPlugin
    HRPKernelObjectPlugin HRPObjectPlugin HRPSVCBodyCellPlugin HRPSVCSignaturePlugin HRPTaskPlugin
    MBedHTTPPlugin Mruby2CBridgePlugin MrubyBridgeCellPlugin MrubyBridgeCelltypePlugin
    MrubyBridgeCompositePlugin MrubyBridgePlugin MrubyBridgeSignaturePlugin
    MrubyInfoBridgeCellPlugin MrubyInfoBridgePlugin MrubyInfoBridgeSignaturePlugin MultiPlugin
    NotifierPlugin OpaqueMarshalerPlugin RepeatCellPlugin SignaturePlugin TECS2CBridgePlugin
    TECSInfoCompoPlugin TECSInfoPlugin
    """)
"""Plug-ins of signatures, celltypes and cells that tecsgen ships."""

DOMAIN = words("""
    ClassPlugin DomainPlugin FMPClassPlugin FMPPlugin HRMPClassPlugin HRMPDomainPlugin HRMPPlugin
    HRP2Plugin HRPPlugin
    """)
"""Plug-ins of domain and class regions, where names omit the suffix `Plugin`."""


@dataclass(slots=True)
class Applied:
    """The third-party plug-ins used in a unit, whose declarations are not known.

    `generators` run at their position and can declare anything; plug-ins on joins and regions
    generate cells once the unit is parsed.
    """

    generators: list[str] = field(default_factory=list)
    on_ways: list[str] = field(default_factory=list)

    @property
    def of_types(self) -> str | None:
        """A plug-in that may already have declared a celltype or signature."""
        return self.generators[-1] if self.generators else None

    @property
    def of_cells(self) -> str | None:
        """A plug-in that may generate a cell."""
        return next(reversed((*self.generators, *self.on_ways)), None)


JOINING = frozenset({"TECSInfoPlugin", "TECSInfoCompoPlugin"})
"""Plug-ins of celltypes that join call ports of the cells automatically."""

TECSGEN = THROUGH | GENERATE | DOMAIN


def class_name(name: str) -> str:
    """Return the class name by which tecsgen loads a plug-in: with an initial capital."""
    return name[:1].upper() + name[1:]


def is_ours(name: str) -> bool:
    """Return whether a name, as written, is that of rtgen's plug-in."""
    return class_name(name) in OURS


def is_known(name: str) -> bool:
    """Return whether the name is that of rtgen's plug-in or of one that tecsgen ships."""
    return is_ours(name) or class_name(name) in TECSGEN or f"{name}Plugin" in DOMAIN


def nearest(name: str) -> str | None:
    """Return the known plug-in whose name is misspelt, if it is likely to be one.

    Names are compared without `Plugin`, which they share. Those that differ by digits alone are of
    other kernels, as are `HRP2TaskPlugin` and `HRP3TaskPlugin`.
    """
    names = {_folded(each): each for each in (*sorted(TECSGEN), OWN_NAME)}
    bare = {each.removesuffix(_SUFFIX): name for each, name in names.items()}
    written = _folded(name)
    stem = written.removesuffix(_SUFFIX)
    if stem in bare:
        return bare[stem]
    from difflib import get_close_matches

    word, known, cutoff = written, names, 0.86
    if stem != written:
        word, known, cutoff = stem, bare, 0.65
    close = get_close_matches(word, known, n=1, cutoff=cutoff)
    if not close or _without_digits(close[0]) == _without_digits(word):
        return None
    return known[close[0]]


def _folded(name: str) -> str:
    return name.replace("-", "").replace("_", "").lower()


def _without_digits(name: str) -> str:
    return "".join(c for c in name if not c.isdigit())


def may_join(name: str) -> bool:
    """Return whether a plug-in of a celltype may join call ports; an unknown plug-in may."""
    return class_name(name) in JOINING or not is_known(name)
