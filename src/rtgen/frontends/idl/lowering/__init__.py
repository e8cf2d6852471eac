"""The checked syntax tree as the model."""
