"""The behaviours of the reference application, by hand on generated base classes."""
