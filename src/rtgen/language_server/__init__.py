"""The language server: what `rtgen lsp` tells editors about definitions, on pygls.

`text` and `documents` hold what editors have open, `indexing` makes tables of names and places of
what the front ends have read, `analysis` runs the compiler on a project with unsaved texts,
`workspace` decides when, `features` has one module for each request, `server` speaks the protocol.
"""
