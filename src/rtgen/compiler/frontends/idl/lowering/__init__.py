"""Lowers the checked syntax tree to the model."""
