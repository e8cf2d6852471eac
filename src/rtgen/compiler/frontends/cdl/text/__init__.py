"""From the bytes of CDL files to text without comments."""
