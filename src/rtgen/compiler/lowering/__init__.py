"""Lowerings: transformations from model to model, applied before any back end.

They turn boards of CDL files, devices, profiles and adapters into types, interfaces and components,
which back ends support.
"""
