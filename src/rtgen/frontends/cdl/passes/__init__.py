"""The passes over a parsed unit; each reads and extends the symbol table."""
