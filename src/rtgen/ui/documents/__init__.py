"""The file of a system with a user's edits: changed where it was edited, and nowhere else."""
