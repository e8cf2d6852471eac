"""From the bytes of CDL files to text with comments blanked."""
