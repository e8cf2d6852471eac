"""Back end for the target typescript: IDL types for a browser, with their codecs."""
