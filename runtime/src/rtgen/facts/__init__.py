"""Tables and grammars of the standards, shared by compiler and runtime.

Each fact is defined once. The package imports nothing of rtgen and no third-party library.
"""
