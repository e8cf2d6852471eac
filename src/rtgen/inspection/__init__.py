"""Output of `rtgen inspect`: JSON of a model, and text made from it."""
