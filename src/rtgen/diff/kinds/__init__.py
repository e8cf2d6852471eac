"""The kinds of changes, one module for each world: the facts behind `rtgen diff`."""
