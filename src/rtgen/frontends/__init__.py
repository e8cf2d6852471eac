"""Front ends: text to model, one package or module for each input language."""
