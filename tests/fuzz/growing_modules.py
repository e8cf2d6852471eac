"""Modules of OpenRTM, as `rtgen adopt` reads them, that are long or deep."""

from __future__ import annotations

from growth import Files, Kinds, chain, lines

ADOPT = (("adopt", "a.py"),)

KINDS = Kinds(ADOPT)


_MODULE = """\
import OpenRTM_aist
import RTC
spec = ["implementation_id", "Part", "type_name", "Part", {spec}]
class Part(OpenRTM_aist.DataFlowComponentBase):
    def __init__(self, manager):
        OpenRTM_aist.DataFlowComponentBase.__init__(self, manager)
        {body}
"""
_ADDED = 'self.p = OpenRTM_aist.InPort("{0}", RTC.TimedLong(RTC.Time(0, 0), 0))\n'
_ADDED += '        self.addInPort("{0}", self.p)'


def _module(spec: str = "", body: str = "pass", head: str = "") -> Files:
    return {"a.py": head + _MODULE.format(spec=spec, body=body)}


@KINDS.add(4301, 100000)
def numbers_of_many_digits(size: int) -> Files:
    digits = "9" * size
    return _module(
        spec=f'"conf.default.x", str({digits}), "max_instance", "{digits}"',
        body=f"self.x = [{digits}]",
    )


@KINDS.add(4301, 20000)
def hexadecimal_numbers(size: int) -> Files:
    digits = "0x" + "f" * size
    return _module(spec=f'"conf.default.x", str({digits})', body=f"self.x = [{digits}]")


@KINDS.add(500, 2000, 100000)
def chain_of_attributes(size: int) -> Files:
    return _module(body=f"self{'.a' * size} = 1\n        self{'.a' * size}()")


@KINDS.add(500, 2000, 100000)
def chain_of_sums(size: int) -> Files:
    texts = " + ".join(['"a"'] * size)
    return _module(spec=f'"description", {texts}', body=f"x = {texts}")


@KINDS.add(500, 2000, 100000)
def chain_of_calls(size: int) -> Files:
    return _module(body=f"self.a{'()' * size}\n        self{'.a()' * size}")


@KINDS.add(80, 2000, 100000)
def nested_lists(size: int) -> Files:
    return _module(
        spec="[" * size + "]" * size, body=f"self.x = {'[' * size}{']' * size}"
    )


@KINDS.add(80, 2000)
def nested_tuples(size: int) -> Files:
    left, right = "(" * size, ",)" * size
    return _module(body=f"{left}a{right} = {left}1{right}")


@KINDS.add(2000, 20000)
def chain_of_classes(size: int) -> Files:
    text = lines(size, lambda i: f"class C{i}(C{i + 1}): pass")
    return _module(body="pass" + "\n" + text)


@KINDS.add(60, 2000)
def diamonds_of_classes(size: int) -> Files:
    line = "class C{0}(C{1}, D{1}): pass\nclass D{0}(C{1}, D{1}): pass"
    text = lines(size, lambda i: line.format(i, i + 1))
    return _module(body="pass" + "\n" + text)


@KINDS.add(60, 2000)
def variables_that_double(size: int) -> Files:
    text = chain(size, "v0 = 'ab'", "v{0} = v{1} + v{1}")
    return _module(head=text + "\n", spec=f'"description", v{size}')


@KINDS.add(60, 90, 2000)
def nested_blocks(size: int) -> Files:
    blocks = [f"{' ' * (8 + i)}if x:" for i in range(size)]
    return _module(body="\n".join(["pass", *blocks, f"{' ' * (8 + size)}pass"]))


@KINDS.add(5000)
def module_with_ports(size: int) -> Files:
    return _module(
        body="\n        ".join(
            _ADDED.format(f"p{i}").replace("self.p", f"self.p{i}") for i in range(size)
        )
    )


@KINDS.add(1_000_000)
def module_with_a_long_name(size: int) -> Files:
    spec = f'"{"k" * size}", "x", "vendor", "{"v" * size}"'
    return _module(spec=spec, body=_ADDED.format("n" * size))


@KINDS.add(1)
def odd_encodings(size: int) -> Files:
    return _module(head="# coding: rot13\n")


@KINDS.add(1_000_000)
def long_encoding(size: int) -> Files:
    return _module(head=f"# coding: {'x' * size}\n")
