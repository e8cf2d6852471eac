"""What `rtgen inspect` shows of a model: JSON, and text made from it."""
