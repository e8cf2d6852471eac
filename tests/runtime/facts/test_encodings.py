"""Which characters the octets of a text file are: `rtgen.facts.encodings`."""

import codecs

import pytest

from rtgen.facts.decoded_text import NotEncodableError, with_line_feeds
from rtgen.facts.encodings import Encoded, decode, digest, labelled

TEXT = """\
/* 目標位置と表示ソフトの設定 */
struct Pose {
  double x;   // X座標の表
  double y;   // Y座標「予定」
\tdouble a;\u3000// 角度①、ﾓｰﾀｰ側の十
};
"""
CODECS = {"utf8": "utf-8", "sjis": "cp932", "euc": "euc_jis_2004"}


@pytest.mark.parametrize("encoding", CODECS)
@pytest.mark.parametrize("asked", ["auto", ""])
@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_a_text_is_the_same_in_each_encoding(
    encoding: str, asked: str, end: str
) -> None:
    data = TEXT.replace("\n", end).encode(CODECS[encoding])
    read = decode(data, asked or encoding)
    assert read.normal == TEXT
    assert (read.encoding, read.doubt) == (encoding, None)
    assert read.encode(read.text) == data
    place = TEXT.index("\n") if end == "\r" else None
    assert read.lone_return == place


@pytest.mark.parametrize(
    ("mark", "codec"),
    [
        (codecs.BOM_UTF8, "utf-8"),
        (codecs.BOM_UTF16_LE, "utf-16-le"),
        (codecs.BOM_UTF16_BE, "utf-16-be"),
    ],
)
def test_a_byte_order_mark_decides(mark: bytes, codec: str) -> None:
    data = mark + TEXT.encode(codec)
    read = decode(data, "sjis")
    assert (read.text, read.doubt) == (TEXT, None)
    assert read.encode(f"{TEXT}// x") == data + "// x".encode(codec)


@pytest.mark.parametrize(
    ("sign", "euc"),
    [
        ("\uff5e", b"\xa1\xc1"),
        ("\uff0d", b"\xa1\xdd"),
        ("∥", b"\xa1\xc2"),
        ("￠", b"\xa1\xf1"),
        ("￡", b"\xa1\xf2"),
        ("￢", b"\xa2\xcc"),
        ("①", b"\xad\xa1"),
        ("㈱", b"\xad\xea"),
        ("ﾟ", b"\x8e\xdf"),
    ],
)
def test_signs_that_tables_map_differently(sign: str, euc: bytes) -> None:
    """A sign has the character that Microsoft's table gives it, from EUC-JP, too."""
    for data in (
        f"速度の範囲{sign}".encode("cp932"),
        "速度の範囲".encode("euc_jp") + euc,
    ):
        read = decode(data)
        assert (read.text[-1], read.doubt) == (sign, None)
        assert read.encode(read.text) == data


def test_an_encoding_that_does_not_fit_is_doubted() -> None:
    data = TEXT.encode("cp932")
    read = decode(data, "euc")
    assert read.text == TEXT
    assert read.doubt == "the file is not EUC-JP; read as Shift_JIS"
    japanese = "// 回転速度を設定する".encode()
    assert decode(japanese, "sjis").doubt is not None
    assert decode(japanese, "sjis", standard=True).doubt is None


@pytest.mark.parametrize(
    "text",
    ["Gerätebau", "25 °C", "±5 µm", "m/s²", "© Schönaich", "naïve", "Ø 5", "“x” · €"],
)
def test_european_text_is_windows_1252(text: str) -> None:
    data = f"VendorName={text}\r\n".encode("cp1252")
    read = decode(data)
    assert read.text == f"VendorName={text}\r\n"
    assert read.doubt is not None
    assert "Windows-1252" in read.doubt
    assert read.encode(read.text) == data
    assert decode(read.text.encode()).doubt is None


def test_every_octet_has_a_character() -> None:
    data = bytes(range(256))
    read = decode(data, "none")
    assert read.doubt is None
    assert len(read.text) == 256
    assert read.encode(read.text) == data


def test_two_encodings_that_fit_equally_well_are_doubted() -> None:
    read = decode("// 渡".encode("euc_jp"))
    assert read.doubt is not None
    assert "Shift_JIS" in read.doubt
    assert "EUC-JP" in read.doubt
    assert decode("// 渡".encode("euc_jp"), "euc").doubt is None


def test_a_file_of_two_encodings_is_read_line_by_line() -> None:
    lines = ["// 速度の表", "double v;", "// 予定、十", "double a; // 単位は°"]
    data = "\n".join(lines).encode()
    data = data.replace(lines[2].encode(), lines[2].encode("cp932"))
    read = decode(data)
    assert read.text == "\n".join(lines)
    assert read.doubt == "this line is not UTF-8, as others are; read as Shift_JIS"
    assert read.line == 3
    with pytest.raises(NotEncodableError, match="予"):
        decode(data + "\n// 予".encode()).encode(read.text)
    assert read.encode(read.text.replace(" ", "  ")) == data.replace(b" ", b"  ")


@pytest.mark.parametrize("line", ["ﾗ婁ﾎ媾", "ﾞⅨ"])
def test_a_line_that_is_utf_8_by_chance_makes_no_mixture(line: str) -> None:
    text = f"// 速度の表\n// ''{line}\n// 角度の十\n"
    line.encode("cp932").decode()
    read = decode(text.encode("cp932"))
    assert (read.text, read.encoding, read.doubt) == (text, "sjis", None)


def test_damage_is_one_character() -> None:
    data = "// X座標の表\n// Y座標\n".encode("cp932")
    read = decode(data.replace("標".encode("cp932"), b"\xff", 1))
    assert read.text == "// X座ÿの表\n// Y座標\n"
    assert (read.encoding, read.line) == ("sjis", 1)
    assert read.doubt is not None


def test_characters_without_a_way_back_keep_their_octets() -> None:
    data = b"// \x87\x90 \x81\xe0".replace(b"\x81\xe0", "ほぼ等しい".encode("cp932"))
    read = decode(data)
    assert read.text == "// ≒ ほぼ等しい"
    assert read.encode(f"{read.text} // .") == data + b" // ."
    both = decode(b"// \x87\x90 \x81\xe0 " + "ほぼ".encode("cp932"))
    with pytest.raises(NotEncodableError, match="≒"):
        both.encode(both.text)


def test_unsaved_texts_are_what_they_are() -> None:
    """Octets that fit two encodings are those of the text that an editor has."""
    text = "// ÷ ﾃｷ"
    assert decode(Encoded(text.encode()), "sjis").text == text
    data = Encoded("// ﾃｷ".encode("cp932"), "sjis")
    assert decode(data).text == "// ﾃｷ"


@pytest.mark.parametrize(
    ("label", "codec"),
    [
        ("Shift_JIS", "cp932"),
        ("MS_Kanji", "cp932"),
        ("Windows-31J", "cp932"),
        ("x-sjis", "cp932"),
        ("EUC-JP", "euc_jis_2004"),
        ("eucJP", "euc_jis_2004"),
        ("UTF-8", "utf-8-sig"),
        ("utf-16", "utf-16"),
    ],
)
def test_declared_encodings(label: str, codec: str) -> None:
    assert labelled(TEXT.encode(codec), label) == TEXT


def test_declarations_that_do_not_hold() -> None:
    with pytest.raises(LookupError):
        labelled(b"a", "klingon")
    with pytest.raises(UnicodeDecodeError) as found:
        labelled(b"ab\xff", "shift_jis")
    assert found.value.start == 2


def test_line_ends() -> None:
    assert with_line_feeds("a\rb\r\nc\n\rd") == "a\nb\nc\n\nd"
    assert digest(b"a\r\nb\r\n") == digest(b"a\nb\n")
    assert decode(b"a\r\nb\r\n").lone_return is None
    assert decode(b"a\r\nb\rc").lone_return == 3
