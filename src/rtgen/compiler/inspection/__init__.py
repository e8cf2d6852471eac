"""Output of `rtgen inspect`: JSON of a model, and a text form of it."""
