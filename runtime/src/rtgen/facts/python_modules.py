"""Names of Python modules that those of a project must not hide."""

from __future__ import annotations

import sys

STANDARD = frozenset(sys.stdlib_module_names) | {
    # Until Python 3.12 or 3.13, and since 3.14: names do not depend on the interpreter.
    *("aifc", "asynchat", "asyncore", "audioop", "cgi", "cgitb", "chunk", "crypt"),
    *("distutils", "imghdr", "imp", "lib2to3", "mailcap", "msilib", "nis", "nntplib"),
    *("ossaudiodev", "pipes", "smtpd", "sndhdr", "spwd", "sunau", "telnetlib", "uu"),
    *("xdrlib", "annotationlib", "compression"),
}
"""Modules of Python's standard library."""

LIBRARIES = frozenset(
    {
        "rtgen",
        "rtgen_speed",
        *(
            "PIL",
            "anyio",
            "attr",
            "attrs",
            "can",
            "canopen",
            "cattr",
            "cattrs",
            "click",
        ),
        *("contourpy", "cycler", "cyclonedds", "dateutil", "exceptiongroup", "fissix"),
        *("flexcache", "flexparser", "fontTools", "foxglove", "google", "h11", "idna"),
        *("jedi", "parso"),
        *("jinja2", "kiwisolver", "lark", "lsprotocol", "lz4", "markdown_it"),
        *("markupsafe", "matplotlib", "mcap", "mdurl", "mpl_toolkits", "msgspec"),
        *("numpy", "packaging", "pcpp", "pint", "platformdirs", "pycparser", "pygame"),
        *("pygls", "pygments", "pylab", "pyparsing", "rclpy", "rich", "rich_click"),
        *(
            "serial",
            "six",
            "starlette",
            "tombi",
            "typing_extensions",
            "uvicorn",
            "uvloop",
        ),
        *("watchfiles", "websockets", "wrapt", "xxhash", "yaml", "zenoh", "zstandard"),
    }
)
"""rtgen, and the modules of its requirements, those of its extras included."""

MIDDLEWARE = frozenset(
    {
        *("OpenRTM", "OpenRTM_aist", "RTC", "RTC__POA", "RTM", "RTM__POA"),
        *("SDOPackage", "SDOPackage__POA", "CORBA", "CosNaming", "CosNaming__POA"),
        *("PortableServer", "PortableServer__POA", "omniORB", "omniidl", "omnipy"),
    }
)
"""Modules of OpenRTM-aist-Python and omniORBpy, their stubs of IDL modules included."""


def owner(name: str) -> str | None:
    """Return what has a top-level module of this name, as words; None if a project may use it."""
    if name in STANDARD:
        return "Python"
    if name in LIBRARIES:
        return "rtgen and its requirements"
    return "OpenRTM" if name in MIDDLEWARE else None
