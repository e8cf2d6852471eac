"""Names and places of definitions in all languages: what every feature looks things up in."""
