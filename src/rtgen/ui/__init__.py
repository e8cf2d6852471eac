"""The system editor in a browser: `rtgen ui`."""
