"""Programs of the grammar-based fuzzer: meaningful ones, and ones with an error or two.

A program knows its declarations, so that it gets through the syntax to names, constants, unions,
inheritance and components. Without deliberate errors and reused names it is valid: an error in it
is a defect of the front end (or of this file).
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from random import Random

import idl_words as words

INTEGERS = {
    "short": 16,
    "long": 32,
    "long long": 64,
    "unsigned short": 16,
    "unsigned long": 32,
    "unsigned long long": 64,
    "octet": 8,
    "int8": 8,
    "int16": 16,
    "int32": 32,
    "int64": 64,
    "uint8": 8,
    "uint16": 16,
    "uint32": 32,
    "uint64": 64,
}
FLOATS = ("float", "double", "long double")
STEMS = (
    *(
        "pose",
        "Velocity",
        "tm",
        "data",
        "Arm",
        "x",
        "JOINT",
        "robot_state",
        "seq",
        "E",
        "value",
    ),
    *("position", "Ref", "frame", "kind", "Limit", "a", "B", "Controller", "id", "OK"),
)
SPECIAL = (
    *(
        "_struct",
        "_interface",
        "_any",
        "_Object",
        "from",
        "class",
        "import",
        "None",
        "self",
    ),
    *(
        "print",
        "type",
        "list",
        "int",
        "str",
        "bytes",
        "property",
        "map",
        "bitset",
        "bitmask",
    ),
    *(
        "bitfield",
        "port",
        "component",
        "home",
        "uses",
        "provides",
        "emits",
        "manages",
        "alias",
    ),
    *(
        "typename",
        "connector",
        "porttype",
        "finder",
        "multiple",
        "primarykey",
        "encode",
    ),
    *(
        "to_cdr",
        "from_cdr",
        "discriminator",
        "Final",
        "Decimal",
        "dataclass",
        "field",
        "async",
    ),
)
"""Names that are words of IDL, of Python, or of generated code."""
POOL = (
    "A",
    "a",
    "B",
    "b",
    "C",
    "T",
    "t",
    "S",
    "Foo",
    "foo",
    "_A",
    "M",
    "E",
    "I",
    "x",
    "port",
)


@dataclass(frozen=True)
class Shape:
    """The kind of a type, with its aliases resolved."""

    sort: str
    low: int = 0
    high: int = 0
    bound: int = 0
    scale: int = 0
    values: tuple[tuple[str, ...], ...] = ()
    local: bool = False
    simple: bool = True
    python: bool = True


@dataclass(frozen=True)
class Known:
    """A declaration: its path from the root, spelt as declared."""

    path: tuple[str, ...]
    shape: Shape
    value: object = None


@dataclass
class Style:
    """The style of a program."""

    flaws: float = 0.0
    unique: bool = True
    most: int = 8
    corba: bool = False


@dataclass
class Program:
    """A growing program; `tokens` holds words, punctuation, and whole lines (with a line feed)."""

    chance: Random
    style: Style
    tokens: list[str] = field(default_factory=list)
    scope: tuple[str, ...] = ()
    types: list[Known] = field(default_factory=list)
    constants: list[Known] = field(default_factory=list)
    exceptions: list[Known] = field(default_factory=list)
    interfaces: list[Known] = field(default_factory=list)
    values: list[Known] = field(default_factory=list)
    components: list[Known] = field(default_factory=list)
    modules: list[Known] = field(default_factory=list)
    used: set[str] = field(default_factory=set)
    identified: set[tuple[str, ...]] = field(default_factory=set)
    included: bool = False
    count: int = 0
    made: int = 0

    # Basics

    def put(self, *tokens: str) -> None:
        """Append words and punctuation."""
        self.tokens += tokens

    def line(self, text: str) -> None:
        """Append a line of the preprocessor."""
        self.tokens.append(text + "\n")

    def odds(self, share: float) -> bool:
        """Return True in that share of all draws."""
        return self.chance.random() < share

    def slip(self) -> bool:
        """Return whether to make an error here."""
        return self.style.flaws > 0 and self.chance.random() < self.style.flaws

    def name(self, style: str = "") -> str:
        """Return a new name: unused, unless the style allows duplicates."""
        if not self.style.unique or self.slip():
            return self.chance.choice(POOL)
        if self.odds(0.06):
            word = self.chance.choice(SPECIAL)
            if word.lstrip("_").lower() not in self.used:
                self.used.add(word.lstrip("_").lower())
                return word
        self.count += 1
        escape = "_" if self.odds(0.01) else ""
        return f"{escape}{style or self.chance.choice(STEMS)}{self.count}"

    def path(self, name: str) -> tuple[str, ...]:
        """Return the path of a declaration of this scope."""
        return (*self.scope, name)

    def to(self, known: Known) -> list[str]:
        """Return a name for a declaration: absolute, or relative to this scope."""
        if self.slip():
            return [self.chance.choice((*POOL, *words.KEYWORDS, *words.CONTEXTUAL))]
        path = known.path
        if self.odds(0.25):
            return [token for part in path for token in ("::", part)]
        shared = 0
        while (
            shared < min(len(path) - 1, len(self.scope))
            and path[shared] == self.scope[shared]
        ):
            shared += 1
        start = self.chance.randint(0, shared) if self.odds(0.3) else shared
        return [t for part in path[start:] for t in ("::", part)][1:]

    # Types

    def basic(self) -> tuple[list[str], Shape]:
        """Return a type without a name that is valid anywhere."""
        kind = self.chance.random()
        if kind < 0.45:
            names = list(INTEGERS)[: 7 if self.style.corba else None]
            return self.integer(self.chance.choice(names))
        if kind < 0.65:
            return self.chance.choice(FLOATS).split(), Shape("float")
        if kind < 0.9:
            word = self.chance.choice(("boolean", "char", "wchar", "string", "wstring"))
            bound = 0
            tokens = [word]
            if "string" in word and self.odds(0.3):
                bound = self.chance.randint(1, 300)
                tokens += ["<", *self.bound(bound), ">"]
            return tokens, Shape(word, bound=bound)
        return [self.chance.choice(("any", "Object"))], Shape("any", python=False)

    def integer(self, word: str) -> tuple[list[str], Shape]:
        """Return the integer type of a keyword."""
        bits = INTEGERS[word]
        if word[0] in "uo":
            return word.split(), Shape("integer", 0, 2**bits - 1)
        return word.split(), Shape("integer", -(2 ** (bits - 1)), 2 ** (bits - 1) - 1)

    def simple(self, *, local: bool = False) -> tuple[list[str], Shape]:
        """Return a type for an operation or attribute."""
        if self.slip():
            return self.wrong_type()
        if self.types and self.odds(0.5):
            known = self.chance.choice(self.types)
            if local or not known.shape.local:
                return self.to(known), known.shape
        return self.basic()

    def wrong_type(self) -> tuple[list[str], Shape]:
        """Return something that is not a type, or not valid here."""
        pools = (self.exceptions, self.modules, self.constants, self.components)
        pool = self.chance.choice(pools)
        if pool and self.odds(0.6):
            return self.to(self.chance.choice(pool)), Shape("wrong")
        word = self.chance.choice(
            ("void", "ValueBase", "unsigned", "int", "Absent", "5")
        )
        return [word], Shape("wrong")

    def type(self, depth: int = 0, *, local: bool = False) -> tuple[list[str], Shape]:
        """Return a type for a member, with templates and nested declarations."""
        if depth > 4 or self.odds(0.6):
            return self.simple(local=local)
        kind = self.chance.randrange(9)
        if kind < 4:
            tokens, shape = self.type(depth + 1, local=local)
            bound = self.chance.randint(1, 20)
            limit = [",", *self.bound(bound)] if self.odds(0.4) else []
            return (
                ["sequence", "<", *tokens, *limit, ">"],
                Shape("sequence", local=shape.local, python=shape.python),
            )
        if kind == 4:
            digits = self.chance.randint(1, 31)
            scale = self.chance.randint(0, digits + (1 if self.slip() else 0))
            tokens = ["fixed", "<", *self.bound(digits), ",", *self.bound(scale), ">"]
            return tokens, Shape("fixed", bound=digits, scale=scale)
        if kind == 5 and not self.style.corba:
            key, _ = self.basic_key()
            tokens, shape = self.type(depth + 1, local=local)
            return ["map", "<", *key, ",", *tokens, ">"], replace(shape, sort="map")
        return self.simple(local=local)

    def basic_key(self) -> tuple[list[str], Shape]:
        """Return a type for the key of a map."""
        if self.odds(0.5):
            return ["string"], Shape("string")
        return self.integer(self.chance.choice(list(INTEGERS)))

    def bound(self, value: int) -> list[str]:
        """Return an expression of that value."""
        if self.slip():
            return self.chance.choice(
                (["0"], ["-", "1"], ["1.5"], ["4294967296"], ['"a"'])
            )
        for known in self.constants:
            if known.value == value and known.shape.sort == "integer":
                return self.to(known)
        match self.chance.randrange(8):
            case 0 if value > 0:
                return [str(value + 3), "-", "3"]
            case 1:
                return ["(", hex(value), ")"]
            case 2:
                return [str(value * 2), "/", "2"]
            case 3:
                return [str(value << 2), ">>", "2"]
        return [str(value)]

    # Constants

    def constant(self, shape: Shape, depth: int = 0) -> tuple[list[str], object]:
        """Return an expression for a type, and its value."""
        if self.slip():
            pool = (words.NUMBERS, words.TEXTS, words.NAMES, words.MARKS)
            return [self.chance.choice(self.chance.choice(pool))], None
        fitting = [
            k
            for k in self.constants
            if k.shape.sort == shape.sort
            and (
                shape.sort != "integer"
                or (isinstance(k.value, int) and shape.low <= k.value <= shape.high)
            )
            and k.shape.values == shape.values
            and (shape.sort not in ("string", "wstring", "fixed"))
        ]
        if fitting and self.odds(0.3):
            known = self.chance.choice(fitting)
            return self.to(known), known.value
        match shape.sort:
            case "integer":
                return self.whole(shape, depth)
            case "float":
                return self.real(depth), None
            case "fixed":
                digits = min(max(shape.bound - shape.scale, 0), 6)
                whole = self.chance.randint(0, 10**digits - 1)
                return [
                    (
                        f"{whole}.{self.chance.randint(0, 9)}d"
                        if shape.scale
                        else f"{whole}d"
                    )
                ], None
            case "boolean":
                return [self.chance.choice(("TRUE", "FALSE"))], None
            case "char" | "wchar":
                wide = "L" if shape.sort == "wchar" else ""
                return [f"{wide}'{self.letter(wide)}'"], None
            case "string" | "wstring":
                return self.string(shape), None
            case "enum":
                path = self.chance.choice(shape.values)
                return self.to(Known(path, shape)), path
        return ["0"], None

    def letter(self, wide: str) -> str:
        """Return a character or escape of a literal."""
        if wide and self.odds(0.2):
            return self.chance.choice(("\\u3042", "\\u41", "\\ue9"))
        return self.chance.choice(
            (
                *"abcXYZ019 _.;{}#",
                "\\n",
                "\\t",
                "\\\\",
                "\\'",
                '\\"',
                "\\?",
                "\\x41",
                "\\101",
                "\\a",
            )
        )

    def string(self, shape: Shape) -> list[str]:
        """Return literals with at most as many characters as the bound."""
        wide = "L" if shape.sort == "wstring" else ""
        room = shape.bound or 12
        parts = []
        for _ in range(self.chance.choice((1, 1, 1, 2, 3))):
            length = self.chance.randint(0, min(room, 8))
            room -= length
            text = "".join(self.letter(wide) for _ in range(length))
            parts.append(f'{wide}"{text}"')
        return parts

    def real(self, depth: int) -> list[str]:
        """Return a floating-point expression of a moderate value."""
        if depth > 3 or self.odds(0.6):
            return [
                self.chance.choice(("0.5", "1.", ".25", "3e2", "1E-3", "12.75", "1e10"))
            ]
        if self.odds(0.2):
            return [self.chance.choice("+-"), self.chance.choice(("1.5", "2e1"))]
        operator = self.chance.choice("+-*/")
        tokens = [*self.real(depth + 1), operator, *self.real(4)]
        return ["(", *tokens, ")"]

    def whole(self, shape: Shape, depth: int) -> tuple[list[str], int]:
        """Return an integer expression; all intermediate values fit a compiler's integers."""
        edge = 63 if max(shape.high, -shape.low - 1) >= 2**32 else 31
        tokens, value = self.tree(depth, -(2**edge), 2 ** (edge + 1) - 1, shape.low < 0)
        if shape.low <= value <= shape.high:
            return tokens, value
        if value >= 0 and self.odds(0.5):
            value &= shape.high
            return [*tokens, "&", str(shape.high)], value
        value = self.chance.choice((shape.high, 0, 1, shape.high // 2))
        return [str(value)], value

    def tree(
        self, depth: int, low: int, high: int, signed: bool
    ) -> tuple[list[str], int]:
        """Return an expression whose parts lie in a range, and its value."""
        if depth > 4 or self.odds(0.5):
            value = self.chance.choice(
                (
                    0,
                    1,
                    2,
                    3,
                    7,
                    8,
                    10,
                    31,
                    100,
                    255,
                    256,
                    32767,
                    65535,
                    2147483647,
                    high,
                )
            )
            form = self.chance.choice(
                (str, str, str, hex, lambda v: f"0{v:o}", lambda v: f"0X{v:X}")
            )
            if signed and self.odds(0.2) and -value >= low:
                return ["-", form(value)], -value
            return [form(value)], value
        left, a = self.tree(depth + 1, low, high, signed)
        right, b = self.tree(depth + 1, low, high, signed)
        operator = self.chance.choice(
            ("|", "^", "&", "+", "-", "*", "/", "%", "<<", ">>")
        )
        if operator in ("/", "%") and (b == 0 or a < 0 or b < 0):
            operator = "+"
        if operator in ("<<", ">>") and not 0 <= b < 31:
            operator = "&"
        value = {
            "|": lambda: a | b,
            "^": lambda: a ^ b,
            "&": lambda: a & b,
            "+": lambda: a + b,
            "-": lambda: a - b,
            "*": lambda: a * b,
            "/": lambda: a // b,
            "%": lambda: a % b,
            "<<": lambda: a << b,
            ">>": lambda: a >> b,
        }[operator]()
        if not low <= value <= high:
            return left, a
        return ["(", *left, operator, *right, ")"], value
