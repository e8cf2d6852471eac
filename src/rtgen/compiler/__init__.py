"""The compiler: definitions to a model, a model to files."""
