#error not for this board
