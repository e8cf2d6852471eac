"""Back end for small boards: types, component bases and a runtime with fixed buffers."""
