"""Kinds of changes, one module for each input language: the facts behind `rtgen diff`."""
