"""Data ports (OpenRTM): buffers, subscription types, and the connectors between them."""
