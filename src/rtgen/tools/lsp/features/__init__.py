"""Features: one module for each request, from a view of a document to the response."""
