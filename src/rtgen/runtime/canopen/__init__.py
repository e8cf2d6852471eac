"""CANopen runtime (CiA 301, 305): what generated proxies, devices and codecs import."""
