"""The table of a unit: scopes, entities, and what later passes know of these."""
