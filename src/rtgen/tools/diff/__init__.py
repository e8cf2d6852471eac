"""Semantic comparison of two versions of definitions: what changed, what breaks, and for whom."""
