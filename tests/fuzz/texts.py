"""Fuzzing of encodings: comments and literals of Japanese text in UTF-8, Shift_JIS and EUC-JP.

Each case is an IDL file, a CDL file with a header, or a device description. In each encoding, and
with any line ends, it has the model and the text of the file in UTF-8 with line feeds.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from random import Random
from typing import Any

from fuzzing import ViolationError, log_uniform
from msgspec.structs import replace

from rtgen.compiler.diagnostics import Diagnostic
from rtgen.compiler.frontends import FrontendResult
from rtgen.compiler.frontends.cdl import load as load_cdl
from rtgen.compiler.frontends.eds import load as load_eds
from rtgen.compiler.frontends.idl import load as load_idl
from rtgen.facts.encodings import decode

ASKED = {"utf8": "utf-8", "sjis": "cp932", "euc": "euc"}
_OF_ENCODINGS = ("TXT", "CDL0005", "EDS0005")
"""Codes of diagnostics that may differ."""

_WORDS = """
    位置 速度 加速度 角度 角速度 目標 現在 制御 電流 電圧 車輪 姿勢 距離 時刻 周期 表示
    表 機能 能力 予定 十分 構成 設定 初期化 停止 開始 終了 左 右 前 後 手先 座標 座標系
    状態 番号 名前 単位 最大 最小 範囲 誤差 補正 値 型 配列 モータ センサ エラー データ
    ロボット アーム サービス コンポーネント ポート インタフェース パラメータ ソフト
    を の に は が と から まで する です ます である の場合 について ﾓｰﾀ ﾓｰﾀｰ ｾﾝｻ ﾃﾞｰﾀ
    ｴﾗｰ ﾛﾎﾞｯﾄ ﾎﾟｰﾄ ｺﾝﾌｨｸﾞ ｻｰﾋﾞｽ ｱｰﾑ ﾘﾐｯﾄ ｽﾃｰﾀｽ ｶｳﾝﾀ
""".split()
_SIGNS = "、。・「」（）：－～①㈱℃→\u3000\u3000\u3000ー"  # noqa: RUF001
_ASCII = ("x", "Y", " ", "  ", "0x10", "m/s", "[mm]", "\\", "'", '"', "//", "*", "?")
_ENDS = ("\n", "\r\n", "\r")


@cache
def _with_backslash() -> list[str]:
    """Return the characters of JIS X 0208 whose second octet in Shift_JIS is 5Ch."""
    leads = (*range(0x81, 0xA0), *range(0xE0, 0xEB))
    pairs = [bytes((lead, 0x5C)).decode("cp932", "replace") for lead in leads]
    return [pair for pair in pairs if len(pair) == 1 and pair != "\ufffd"]


@cache
def _kanji() -> list[str]:
    """Return the kanji of JIS X 0208, those of level 1 ten times."""
    found = []
    for row in range(0xB0, 0xF5):
        for cell in range(0xA1, 0xFF):
            kanji = bytes((row, cell)).decode("euc_jp", "ignore")
            found += [kanji] * (10 if row < 0xD0 else 1) if kanji else []
    return found


def encoded(text: str, encoding: str) -> bytes:
    """Encode a text; EUC-JP has the characters of Shift_JIS at the places of JIS X 0208."""
    if encoding != "euc":
        return text.encode(encoding)
    octets = bytearray()
    for character in text:
        code = character.encode("cp932")
        if len(code) == 1:
            octets += code if code.isascii() else b"\x8e" + code
            continue
        lead, trail = code
        row = (lead - (0x81 if lead < 0xA0 else 0xC1)) * 2
        cell = trail - (0x40 if trail < 0x7F else 0x41)
        row, cell = (row + 1, cell - 94) if cell >= 94 else (row, cell)
        octets += bytes((row + 0xA1, cell + 0xA1))
    return bytes(octets)


class TextsTarget:
    """Readers of definitions, with random Japanese texts."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def make(self, number: int) -> bytes:
        """Return the files of a case, in UTF-8 with line feeds."""
        return "\n".join(_files(number).values()).encode()

    def check(self, number: int, data: bytes) -> Iterator[str]:
        """Read the case in each encoding, asked for or guessed."""
        files = _files(number)
        expected = self._read(files, "utf-8", "auto")
        chance = Random(number)
        mixed = {name: _with_ends(text, chance) for name, text in files.items()}
        for name, codec in ASKED.items():
            if self._read(mixed, codec, name) != expected:
                raise ViolationError(f"another model in {name}")
        for name in ("sjis", "euc"):
            yield self._guessed(mixed, name, expected)

    def _guessed(self, files: dict[str, str], name: str, expected: object) -> str:
        found = self._read(files, ASKED[name], "auto")
        if found == expected:
            return f"guessed {name}"
        doubted = any(d.code in _DOUBTS for d in self._diagnostics)
        wrong = [
            text
            for text in files.values()
            if decode(encoded(text, ASKED[name])).text != text
        ]
        characters = max(
            sum(not c.isascii() for c in text) for text in wrong or files.values()
        )
        if not doubted and characters > _MANY:
            raise ViolationError(f"{name} with {characters} characters read otherwise")
        return f"{'doubted' if doubted else 'wrong'} {name}"

    def _read(self, files: dict[str, str], codec: str, asked: str) -> object:
        """Return everything that is read of a case but octets and their findings."""
        for name, text in files.items():
            (self._folder / name).write_bytes(encoded(text, codec))
        main = self._folder / next(iter(files))
        result = _LOAD[main.suffix]([main], root=self._folder, encoding=asked)
        self._diagnostics = result.diagnostics
        return (
            _content(result),
            {name: text for name, text in result.sources.items() if name[-2:] != ".h"},
            [d for d in result.diagnostics if not d.code.startswith(_OF_ENCODINGS)],
        )

    _diagnostics: tuple[Diagnostic, ...] = ()


_DOUBTS = ("TXT0001", "CDL0005")
_MANY = 40
_LOAD: dict[str, Callable[..., FrontendResult]] = {
    ".idl": load_idl,
    ".cdl": load_cdl,
    ".eds": load_eds,
}


def _content(result: FrontendResult) -> Any:
    model = result.model
    devices = [replace(device, sha256="") for device in model.devices]
    return model.declarations, model.tecs, devices


def _with_ends(text: str, chance: Random) -> str:
    """Return a text with other line ends: of one kind, or mixed."""
    lines = text.split("\n")
    kinds = chance.choice([("\n",), ("\r\n",), ("\r",), _ENDS])
    ends = [*(chance.choice(kinds) for _ in lines[1:]), ""]
    return "".join(line + end for line, end in zip(lines, ends, strict=True))


def _files(number: int) -> dict[str, str]:
    """Return the files of a case by name, the main file first."""
    chance = Random(number)
    match number % 3:
        case 0:
            return {"a.idl": _idl(chance)}
        case 1:
            return {"a.cdl": _cdl(chance), "a.h": _header(chance)}
        case _:
            return {"a.eds": _eds(chance)}


def _text(chance: Random, *, avoid: str = "") -> str:
    """Return a random text of one line, often with a last octet 5Ch in Shift_JIS."""
    parts: list[str] = []
    for _ in range(log_uniform(1, 8, chance.random())):
        match chance.randrange(12):
            case 0:
                parts.append(chance.choice(_with_backslash()))
            case 1:
                parts.append(chance.choice(_SIGNS))
            case 2:
                parts.append(chance.choice(_ASCII))
            case 3:
                parts.append(chance.choice(_kanji()))
            case 4:
                number = chance.randrange(1, 4)
                parts += [chr(chance.randrange(0xFF66, 0xFFA0)) for _ in range(number)]
            case _:
                parts.append(chance.choice(_WORDS))
    match chance.randrange(6):
        case 0 | 1 | 2:
            parts.append(chance.choice(_with_backslash()))
        case 3:
            parts.append("\\")
        case 4:
            parts.append(chance.choice((" ", "\t", "\u3000")))
    text = "".join(parts)
    for character in avoid:
        text = text.replace(character, "")
    return text or "表"


def _comment(chance: Random) -> str:
    mark = chance.choice(("//", "//", "///", "///<", "/*", "/**"))
    if mark[1] == "/":
        return f"{mark} {_text(chance)}"
    lines = [_text(chance, avoid="*") for _ in range(chance.randrange(1, 4))]
    return f"{mark} " + "\n * ".join(lines) + " */"


def _lines(chance: Random, lines: list[str]) -> str:
    """Return lines with comments behind or above many of them."""
    made: list[str] = []
    for line in lines:
        if chance.random() < 0.3:
            made.append(_comment(chance))
        behind = f"   {_comment(chance)}" if chance.random() < 0.6 else ""
        made.append(line + behind)
    return "\n".join(made) + chance.choice(("\n", ""))


def _idl(chance: Random) -> str:
    members = [f"  double m{i};" for i in range(chance.randrange(1, 6))]
    title = _text(chance, avoid='\\"')
    return _lines(
        chance,
        [
            "module lab {",
            "struct S {",
            *members,
            "};",
            f'const string TITLE = "{title}";',
            "interface I {",
            *[f"  void f{i}();" for i in range(chance.randrange(4))],
            "};" if chance.random() < 0.9 else "  long broken();\n};",
            "};",
        ],
    )


def _cdl(chance: Random) -> str:
    title = _text(chance, avoid='\\"')
    functions = [f"  int32_t f{i}(void);" for i in range(chance.randrange(1, 5))]
    return _lines(
        chance,
        [
            'import_C("a.h");',
            "signature sS {",
            *functions,
            "  void g([in] const Place *place);",
            "};",
            f'const char_t *const TITLE = "{title}";',
        ],
    )


def _header(chance: Random) -> str:
    members = [f"  int m{i};" for i in range(chance.randrange(1, 6))]
    return _lines(chance, ["typedef struct {", "  int first;", *members, "} Place;"])


def _eds(chance: Random) -> str:
    lines = ["[FileInfo]", "FileName=a.eds", f"Description={_text(chance)}"]
    lines += ["[DeviceInfo]", f"VendorName={_text(chance)}"]
    lines += [f"ProductName={_text(chance)}", "VendorNumber=1"]
    lines += ["[MandatoryObjects]", "SupportedObjects=1", "1=0x1000"]
    numbers = [0x2000 + i for i in range(chance.randrange(1, 5))]
    lines += ["[ManufacturerObjects]", f"SupportedObjects={len(numbers)}"]
    lines += [f"{i}=0x{number:X}" for i, number in enumerate(numbers, 1)]
    for number in (0x1000, *numbers):
        lines += [f"[{number:X}]", f"ParameterName={_text(chance)}", "ObjectType=0x7"]
        lines += ["DataType=0x0007", "AccessType=ro", "PDOMapping=0"]
        if chance.random() < 0.3:
            lines.append(f"; {_text(chance)}")
    return "\n".join(lines) + "\n"
