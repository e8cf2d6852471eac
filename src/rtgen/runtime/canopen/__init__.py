"""CANopen at run time: what generated proxies, devices and codecs import."""
