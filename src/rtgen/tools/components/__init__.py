"""Components of definitions and foreign modules, as commands read and print them."""
