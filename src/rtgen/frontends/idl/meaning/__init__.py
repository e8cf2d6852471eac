"""What declarations mean: types, constant expressions, annotations, and the checks of them."""
