"""Semantics of declarations: types, constant expressions, annotations, and checks."""
