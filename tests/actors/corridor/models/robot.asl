// The cart, as what the child hears of it.
