"""The passes over a parsed unit; each reads the table of the unit and adds to it."""
