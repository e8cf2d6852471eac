"""Texts that would be code if they got into a file without quoting.

Each contains MARK, which distinguishes it in a file from text written by rtgen. A text has a twin,
one harmless word, for the same definition without anything hostile.
"""

from __future__ import annotations

from random import Random

MARK = "PWNED"

ALL = (
    "PWNED",
    '"); PWNED(); x = ("',
    "'); PWNED(); x = ('",
    '"\nPWNED()\n"',
    '"""\nPWNED()\n"""',
    "'''#PWNED",
    '\\"""; PWNED(); """',
    "PWNED\\",
    "PWNED\\\n",
    'PWNED"',
    "PWNED'",
    '"""""PWNED"""""',
    "x\n    PWNED: 1",
    "PWNED\nmanager.modules.preload: PWNED.py",
    "PWNED\r\nmanager.modules.preload = PWNED.py",
    "PWNED\rPWNED()",
    "PWNED\x0bPWNED()",
    "PWNED\x0cPWNED()",
    "PWNED\x85PWNED()",
    "PWNED\u2028PWNED()",
    "PWNED\u2029PWNED()",
    "\ufeffPWNED",
    "PWNED\x1b[2J\x07",
    "PWNED²",
    "\uff30PWNED",
    "℘PWNED·",
    "é ü 漢字 PWNED 🤖",
    "\u202ePWNED\u202c",
    "{{ PWNED }}",
    "{% set PWNED = 1 %}{{ self._TemplateReference__context }}",
    "{PWNED}",
    "%(PWNED)s %s %n",
    "$(PWNED)",
    "`PWNED`",
    "${PWNED}",
    "'; PWNED; '",
    '"; PWNED; "',
    "%PWNED%",
    "!PWNED!",
    "PWNED & PWNED",
    "PWNED | PWNED > PWNED",
    "-->PWNED<!--",
    "--PWNED--",
    "]]>PWNED<![CDATA[",
    "&PWNED;",
    "<PWNED/>",
    "</title><script>PWNED()</script>",
    '" PWNED="',
    "*/ PWNED /*",
    "// PWNED",
    "/* PWNED",
    "# PWNED",
    "; PWNED",
    "#define PWNED\n#include <PWNED>",
    "??/PWNED",
    "[PWNED]",
    "PWNED=PWNED",
    "a:b:PWNED",
    "PWNED.PWNED",
    "../PWNED",
    "C:\\PWNED",
    " PWNED ",
    "import PWNED",
    "  # fmt: skip PWNED",
    "# fmt: off PWNED",
    "# The module spec. PWNED",
    "PWNED | PWNED if PWNED else PWNED for PWNED in PWNED, (PWNED): " * 3,
    "(" * 60 + MARK,
    "PWNED" + '"' * 90,
    "PWNED " * 60,
    "-PWNED",
    "!PWNED",
    "@PWNED",
    "PWNED,PWNED;PWNED",
    "#{PWNED}",
    "lambda: PWNED",
    "__import__('os').system('PWNED')",
)


class Texts:
    """Draws texts for the places of definitions; `used` are those that outputs must keep.

    `count` is the number of texts drawn. Harmless ones are in brackets, as units are, where those
    of the same number are and `bracketed` is true.
    """

    def __init__(self, number: int, *, hostile: bool, bracketed: bool = False) -> None:
        self._bracketed = bracketed
        self._chance = Random(number)
        self._hostile = hostile
        self._odd = self._chance.random() < 0.1
        self.count = 0
        self.used: list[str] = []

    def text(
        self,
        *,
        keep: bool = True,
        one_line: bool = False,
        xml: bool = False,
        printable: bool = False,
        conf: bool = False,
    ) -> str:
        """Return a unique text; `keep`: outputs must contain it unchanged.

        `xml` and `one_line` exclude what the input language itself cannot express; `printable` what
        it refuses and `conf` what configuration files cannot hold, except in every tenth project.
        """
        self.count += 1
        drawn = self._chance.choice(ALL)
        text = drawn.replace(MARK, f"{MARK}{self.count}", 1)
        if self._chance.random() < 0.2:
            text += self._chance.choice(ALL)
        if printable and not self._odd:
            text = "".join(c for c in text if c.isprintable()).strip()
        if conf and not self._odd:
            text = "".join(c for c in text if c.isprintable() and c not in "\\:=#!")
            text = text.strip()
        if xml:
            text = "".join(c for c in text if c >= " " or c in "\t\n\r")
        if one_line:
            text = " ".join(text.splitlines()).strip()
        if not self._hostile:
            is_unit = self._bracketed and text[:1] == "[" and text[-1:] == "]"
            return f"[twin{self.count}]" if is_unit else f"twin{self.count}"
        if keep and (text.isprintable() or not (printable and self._odd)):
            self.used.append(text)
        return text
