"""The marshalling engine: codecs are compiled from descriptions of types, at first use."""
