"""Lowerings: model to model, before any back end. They turn boards of CDL files and adapters
into types, interfaces and components, which back ends support.
"""
