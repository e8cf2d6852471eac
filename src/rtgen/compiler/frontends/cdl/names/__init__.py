"""Symbol table of a unit: scopes, entities, and the facts that later passes add."""
