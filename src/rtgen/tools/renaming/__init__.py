"""Renames of what definitions name, with all that follows: systems, timelines, behaviours."""
