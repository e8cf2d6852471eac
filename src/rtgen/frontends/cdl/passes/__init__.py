"""The passes over a parsed unit: the first line of each says what it reads and what it adds.

They share one symbol table (`names.table`), and are called by `analysis` for one declaration after
the other, since a name of CDL is known only behind its declaration.
"""
