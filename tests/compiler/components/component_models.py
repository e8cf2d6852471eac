"""Small models for the tests of components, built without a front end."""

from rtgen.compiler.backends import Options
from rtgen.compiler.diagnostics import Span
from rtgen.compiler.model import (
    Attribute,
    Component,
    ConfigurationParameter,
    ConstantValue,
    Declaration,
    Direction,
    Enum,
    Enumerator,
    Interface,
    Member,
    Model,
    NamedType,
    Operation,
    Parameter,
    Port,
    PortKind,
    Primitive,
    PrimitiveType,
    SequenceType,
    SourceFile,
    StringType,
    Struct,
    Type,
)

OPTIONS = Options(package="robots", skeleton_package="behaviours", version="0.1.0")
SPAN = Span("specs/Limiter.idl", 3, 11, 3, 18)
DOUBLE = PrimitiveType(Primitive.DOUBLE)
LONG = PrimitiveType(Primitive.LONG)
BOOLEAN = PrimitiveType(Primitive.BOOLEAN)
STRING = StringType()
DOUBLES = SequenceType(DOUBLE)
MODE = NamedType(("Safety", "Mode"))
TYPES, SERVICES, MAIN = "inc/Types.idl", "inc/Safety.idl", "specs/Limiter.idl"


def _named(file: str, name: str) -> dict[str, object]:
    parts = tuple(name.split("::"))
    return {
        "span": SPAN,
        "name": parts,
        "repository_id": f"IDL:{'/'.join(parts)}:1.0",
        "file": file,
    }


TIME = Struct(
    **_named(TYPES, "RTC::Time"),
    members=tuple(
        Member(span=SPAN, name=name, type=PrimitiveType(Primitive.UNSIGNED_LONG))
        for name in ("sec", "nsec")
    ),
)
TIMED_LONG = Struct(
    **_named(TYPES, "RTC::TimedLong"),
    members=(
        Member(span=SPAN, name="tm", type=NamedType(("RTC", "Time"))),
        Member(span=SPAN, name="data", type=LONG),
    ),
)
MODE_ENUM = Enum(
    **_named(SERVICES, "Safety::Mode"),
    members=(
        Enumerator(span=SPAN, name="CLIP", value=0),
        Enumerator(span=SPAN, name="DROP", value=1),
    ),
)
BRAKE = Interface(
    **_named(SERVICES, "Safety::Brake"),
    doc="Stops the base.",
    attributes=(Attribute(span=SPAN, name="engaged", type=BOOLEAN, readonly=True),),
    operations=(
        Operation(
            span=SPAN,
            name="engage",
            returns=BOOLEAN,
            doc="Engages the brake.",
            parameters=(
                Parameter(span=SPAN, direction=Direction.IN, name="force", type=DOUBLE),
                Parameter(
                    span=SPAN, direction=Direction.INOUT, name="from", type=STRING
                ),
                Parameter(span=SPAN, direction=Direction.OUT, name="at", type=LONG),
            ),
        ),
    ),
)
GLOBAL = Interface(**_named(SERVICES, "Component"))


def port(kind: str, name: str, type_: str = "RTC::TimedLong", **more: str) -> Port:
    identifier = more.pop("identifier", name)
    type_name = NamedType(tuple(type_.split("::")))
    if kind in ("provider", "consumer"):
        more = {"port": name, "instance": type_name.name[-1], **more}
    return Port(
        span=SPAN,
        kind=PortKind(kind),
        name=name,
        identifier=identifier,
        type=type_name,
        **more,
    )


def parameter(name: str, type_: Type, default: ConstantValue | None = None, **more: object) -> (
    ConfigurationParameter
):  # fmt: skip
    identifier = str(more.pop("identifier", name))
    return ConfigurationParameter(
        span=SPAN, name=name, identifier=identifier, type=type_, default=default, **more
    )


def component(
    *items: Port | ConfigurationParameter, name: str = "Limiter", **more: object
) -> Component:
    values = {
        "vendor": "Lab",
        "category": "Move",
        "ports": tuple(item for item in items if isinstance(item, Port)),
        "configuration": tuple(
            i for i in items if isinstance(i, ConfigurationParameter)
        ),
        **_named(MAIN, name),
        **more,
    }
    return Component(**values)


def model(*components: Component, more: tuple[Declaration, ...] = ()) -> Model:
    files = ((TYPES, False), (SERVICES, False), (MAIN, True))
    return Model(
        files=tuple(
            SourceFile(name=name, key=name, sha256=f"{number}" * 64, main=main)
            for number, (name, main) in enumerate(files)
        ),
        declarations=(TIME, TIMED_LONG, MODE_ENUM, BRAKE, GLOBAL, *more, *components),
    )
