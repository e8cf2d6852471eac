"""Random components in IDL with all constructs of definitions, for hypothesis."""

from __future__ import annotations

from dataclasses import dataclass

from hypothesis import strategies as st

TYPES = """\
module Lab {
    struct Sample { long tick; double value; };
    union Either switch (boolean) { case TRUE: long whole; case FALSE: double part; };
    typedef Sample Reading;
    enum Mode { CLIP, DROP, KEEP };
    typedef Mode Kind;
    typedef long Count;
    typedef sequence<double,4> Gains;
    typedef string<12> Label;
    interface Brake { void stop(); };
    interface Log { void note(in string text); };
    module Deep { interface Brake { void go(); }; struct Sample { octet raw; }; };
};
struct Bare { float x; };
interface Plain { };
"""
BASE = """\
#include "Types.idl"
/** What others derive from. */
@rtc(category="Base", rate=50.0)
component Ancestor {
    /** From afar. */
    consumes Lab::Sample inherited_in;
    provides Lab::Brake inherited_brake;
    @unit("s") @default(0.5) @min(0.0)
    attribute double inherited_time;
};
module Lab { component Elder : Ancestor supports Lab::Log { publishes Bare elder_out; }; };
"""
FILES = {"Types.idl": TYPES, "Base.idl": BASE}

_NAMES = (
    *("alpha", "B1", "class", "def", "home", "port", "_interface", "x_", "_string"),
    *(
        "status",
        "self",
        "None_",
        "import",
        "_in",
        "config",
        "Data",
        "tm2",
        "of",
        "yield",
    ),
)
_CHARACTERS = st.sampled_from("ab Z09.,;:-+()<>&\"'\\|é日本語√\t")
_DATA_TYPES = (
    *("Lab::Sample", "Lab::Either", "Lab::Reading", "Bare", "Lab::Deep::Sample"),
    *("::Bare", "RTC::TimedDouble"),
)
_INTERFACES = ("Lab::Brake", "Lab::Log", "Plain", "Lab::Deep::Brake")
_INTEGERS = {
    "octet": (0, 255),
    "int8": (-9, 9),
    "uint8": (0, 9),
    "short": (-9, 9),
    "unsigned short": (0, 9),
    "long": (-9, 9),
    "unsigned long": (0, 9),
    "long long": (-(2**40), 2**40),
    "unsigned long long": (0, 2**63),
    "Lab::Count": (-9, 9),
}
_FLOATS = ("float", "double")
_FREE = st.text(_CHARACTERS, min_size=1, max_size=12)
_NAME = _FREE.map(lambda text: text.replace("\t", " ")).filter(str.strip)
_USER = (
    '@acme(x=1, y="text", z=TRUE, w=1.5)',
    "@acme",
    "@acme(Lab::CLIP)",
    "@acme(7)",
    "@transfer_mode(FAST)",
    '@verbatim(language="c++", text="// here")',
)


@dataclass(frozen=True)
class Definition:
    """The text of a file with a component, and the component's name."""

    text: str
    name: str


def quoted(text: str) -> str:
    """Return a string literal of IDL."""
    escapes = {"\\": "\\\\", '"': '\\"', "\t": "\\t"}
    return '"' + "".join(escapes.get(c, c) for c in text) + '"'


@st.composite
def docs(draw: st.DrawFn, margin: str = "    ") -> str:
    """Draw a doc comment of any number of lines, or none."""
    line = st.lists(
        st.sampled_from(
            ["<br/>", "word", "  ", "&amp;", "日本", "é", "]]>", "- item", "\\n"]
        ),
        max_size=4,
    ).map(" ".join)
    lines = draw(st.lists(line, max_size=4))
    if not lines:
        return ""
    if len(lines) == 1:
        return f"{margin}/** {lines[0]} */\n"
    body = "".join(f"{margin} *   {each}\n" for each in lines)
    return f"{margin}/**\n{body}{margin} */\n"


@st.composite
def _annotations(draw: st.DrawFn, own: list[str]) -> str:
    """Draw annotations in any order, some of them the user's."""
    chosen = [*own, *draw(st.lists(st.sampled_from(_USER), max_size=1))]
    return "".join(f"    {each}\n" for each in draw(st.permutations(chosen)))


@st.composite
def _port(draw: st.DrawFn, name: str) -> str:
    word = draw(st.sampled_from(["consumes", "publishes", "emits", "provides", "uses"]))
    own = []
    if draw(st.booleans()):
        own.append(f"@name({quoted(name + draw(_NAME))})")
    if word in ("provides", "uses"):
        type_ = draw(st.sampled_from(_INTERFACES))
        if draw(st.booleans()):
            own.append(f"@port({quoted(draw(st.sampled_from(['P', ' Q ', name])))})")
        own.append(f"@instance({quoted(name + draw(st.sampled_from(['', ' é'])))})")
        if draw(st.booleans()):
            type_names = [type_, type_.rpartition("::")[2], "Other::Name", "a b"]
            own.append(f"@type_name({quoted(draw(st.sampled_from(type_names)))})")
    else:
        type_ = draw(st.sampled_from(_DATA_TYPES))
        if draw(st.booleans()):
            own.append(f"@unit({quoted(draw(_FREE | st.just('')))})")
    annotations = draw(_annotations(own))
    return f"{draw(docs())}{annotations}    {word} {type_} {name};\n"


@st.composite
def _number(draw: st.DrawFn, type_: str) -> list[str]:
    """Draw annotations of a numeric parameter: default, bounds, constraint, widget."""
    if type_ in _FLOATS:
        low, high, default = sorted(draw(st.tuples(*[st.integers(-64, 64)] * 3)))
        texts = [str(value / 4) for value in (low, high, default)]
    else:
        limits = st.integers(*_INTEGERS[type_])
        low, high, default = sorted(draw(st.tuples(limits, limits, limits)))
        texts = [str(value) for value in (low, high, default)]
    lower, inner, upper = texts
    if lower == upper:
        return [f"@default({inner})"]
    bounded = draw(
        st.sampled_from(["", "both", "range", "low", "text", "list", "open"])
    )
    own = {
        "": [],
        "both": [f"@min({lower})", f"@max({upper})"],
        "range": [f"@range(min={lower}, max={upper})"],
        "low": [f"@min({lower})"],
        "text": [f'@constraint("{lower} <= x<={upper}")'],
        "list": [f'@constraint("({lower},{inner}, {upper})")'],
        "open": [f'@constraint("x<={upper}")', f"@min({lower})"],
    }[bounded]
    if bounded in ("both", "range", "text") and draw(st.booleans()):
        own = [
            *own,
            f'@widget("{draw(st.sampled_from(["slider.0.05", "spin", "spin.0.1", "text"]))}")',
        ]
    if bounded == "list" and draw(st.booleans()):
        own = [*own, '@widget("radio")']
    if bounded or draw(st.booleans()):
        own = [*own, f"@default({inner})"]
    return own


@st.composite
def _parameter(draw: st.DrawFn, name: str) -> str:
    type_ = draw(
        st.sampled_from(
            [
                *(
                    *_INTEGERS,
                    *_FLOATS,
                    "boolean",
                    "string",
                    "string<12>",
                    "Lab::Label",
                ),
                *("Lab::Mode", "Lab::Kind", "Lab::Gains"),
                *("sequence<long>", "sequence<string>"),
            ]
        )
    )
    own: list[str] = []
    if type_ in _INTEGERS or type_ in _FLOATS:
        own += draw(_number(type_))
    elif draw(st.booleans()):
        values: dict[str, st.SearchStrategy[str]] = {
            "boolean": st.sampled_from(["TRUE", "FALSE"]),
            "Lab::Mode": st.sampled_from(["Lab::CLIP", "Lab::KEEP"]),
            "Lab::Kind": st.just("Lab::DROP"),
            "Lab::Gains": st.sampled_from(['"1.0, 2"', '"1"', '""']),
            "sequence<long>": st.sampled_from(['"1,2"', '" 3"']),
        }
        own.append(f"@default({draw(values.get(type_, _FREE.map(quoted)))})")
    if draw(st.booleans()):
        own.append(f"@name({quoted(f'{name}{draw(_NAME)}')})")
    if draw(st.booleans()):
        own.append(f"@unit({quoted(draw(_FREE | st.just('')))})")
    annotations = draw(_annotations(own))
    return f"{draw(docs())}{annotations}    attribute {type_} {name};\n"


@st.composite
def _rtc(draw: st.DrawFn) -> str:
    """Draw `@rtc` with some arguments, or nothing."""
    text = _FREE.map(quoted)
    plain = st.sampled_from(["a", "Lab é", ' x"y '.strip()]).map(quoted)
    arguments = {
        "kind": plain,
        "category": plain,
        "vendor": plain,
        "version": st.sampled_from(["1.0.0", "2.1"]).map(quoted),
        "description": text,
        "rate": st.sampled_from(["1000.0", "0.5", "1e3", "33.3"]),
        "max_instances": st.sampled_from(["0", "1", "7"]),
        "activity": st.sampled_from(["PERIODIC", "SPORADIC", "EVENTDRIVEN"]).map(
            quoted
        ),
        "component_type": st.sampled_from(["STATIC", "UNIQUE"]).map(quoted),
        "execution": st.sampled_from(["ExtTrigExecutionContext"]).map(quoted),
        "created": st.just(quoted("2011-09-26T10:00:00.5+09:00")),
        "updated": st.just(quoted("2025-02-11T10:30:00Z")),
    }
    chosen = draw(st.lists(st.sampled_from(sorted(arguments)), unique=True))
    inside = ", ".join(f"{key}={draw(arguments[key])}" for key in chosen)
    return f"@rtc({inside})\n" if chosen else ""


@st.composite
def definitions(draw: st.DrawFn, *, alone: bool = False) -> Definition:
    """Draw a file with a component; `alone`: its types stand in the same file."""
    names = draw(
        st.lists(
            st.sampled_from(_NAMES),
            unique_by=lambda n: n.lower().lstrip("_"),
            max_size=8,
        )
    )
    items = "".join(draw(st.one_of(_port(name), _parameter(name))) for name in names)
    base = (
        "" if alone else draw(st.sampled_from(["", "", " : Ancestor", " : Lab::Elder"]))
    )
    supports = draw(st.sampled_from(["", "", " supports Lab::Brake, Plain"]))
    head = f"{draw(docs(''))}{draw(_rtc())}component Random{base}{supports}"
    text = f"{head} {{\n{items}}};\n"
    module = draw(st.sampled_from(["", "Made", "Lab"]))
    if module:
        text = f"module {module} {{\n{text}}};\n"
    extra = draw(st.sampled_from(["", '#pragma prefix "acme.org"\n']))
    before = TYPES if alone else '#include "Types.idl"\n#include "Base.idl"\n'
    before = f'#include "BasicDataType.idl"\n{before}'
    return Definition(
        before + extra + text, f"{module}::Random" if module else "Random"
    )
