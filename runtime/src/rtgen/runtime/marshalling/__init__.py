"""The marshalling engine: compiles codecs from type descriptors at first use."""
