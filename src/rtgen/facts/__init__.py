"""What the compiler and the runtime both need to know: tables and grammars of the standards.

Each fact stands here once. The package imports nothing of rtgen and no third-party library.
"""
