"""CAN buses: reading, decoding and sending frames."""
