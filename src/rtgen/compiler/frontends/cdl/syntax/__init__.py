"""From text to the syntax tree, with recovery from syntax errors."""
