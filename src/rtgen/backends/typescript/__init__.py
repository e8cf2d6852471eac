"""The target typescript: types of IDL for a browser, with their codecs."""
