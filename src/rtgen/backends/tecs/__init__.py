"""TECS: codecs and what else one `through` of our plug-in asks for."""
