"""Back end for data types and interfaces: Python classes with CDR codecs."""
