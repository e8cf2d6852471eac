"""Stands for a generated network; tests put its content in."""
