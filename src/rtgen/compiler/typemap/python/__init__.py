"""Python names and types for declarations of IDL."""
