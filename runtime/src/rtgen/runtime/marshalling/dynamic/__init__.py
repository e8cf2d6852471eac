"""Marshalling along descriptors: dynamic types, rare ones, and the location of faults."""
