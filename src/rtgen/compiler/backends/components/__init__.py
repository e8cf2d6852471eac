"""Back end for components: base class, configuration, skeleton, factory entries."""
