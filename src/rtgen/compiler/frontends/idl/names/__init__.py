"""Scopes and names (OMG IDL 4.2, 7.5): declarations, lookup, repository ids."""
