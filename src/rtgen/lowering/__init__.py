"""Lowerings: model to model, before any back end. What a model has in a form of its own, boards
of CDL files and adapters, becomes types, interfaces and components, which back ends know.
"""
