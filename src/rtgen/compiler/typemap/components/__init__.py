"""Properties of components: callbacks, annotations, names, and configuration parameters."""
