"""Index of names and places in all languages, used by all features."""
