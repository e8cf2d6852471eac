"""Passes over a parsed unit; the first line of each says what it reads and what it adds.

They share one symbol table (`names.table`). `analysis` calls them for each declaration in turn,
since a name of CDL is visible only after its declaration.
"""
