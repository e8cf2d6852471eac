"""The mapping tables of the field as data: each once, each row with its source."""
