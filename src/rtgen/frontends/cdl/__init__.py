"""CDL, the component description language of TECS: files to a unit of the model."""
