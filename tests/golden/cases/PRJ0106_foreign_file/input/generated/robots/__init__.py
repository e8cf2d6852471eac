"""A package that somebody wrote by hand."""
