"""CANopen runtime (CiA 301, 305) for generated proxies, devices and codecs."""
