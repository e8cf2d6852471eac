"""The grammar of OMG IDL 4.2: the parser, the syntax tree, and explanations of syntax errors."""
