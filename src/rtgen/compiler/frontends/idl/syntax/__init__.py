"""Grammar of OMG IDL 4.2: parser, syntax tree, and diagnostics of syntax errors."""
