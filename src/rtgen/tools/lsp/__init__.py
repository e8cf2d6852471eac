"""Language server for `rtgen lsp`, based on pygls.

`text` and `documents` contain the open documents, `indexing` makes tables of names and places from
the results of front ends, `analysis` runs the compiler on a project with unsaved texts, `workspace`
decides when, `features` has one module for each request, `server` implements the protocol.
"""
