"""Back end of CANopen devices."""
