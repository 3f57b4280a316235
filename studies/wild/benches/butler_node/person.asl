// Guests order, also while another order is on its way, and also in words that are no number.
@once  +!visit : one_order  <- !say.
@twice +!visit : two_orders <- !say; wait; !say.
@both  +!visit : at_once    <- !say; !say.
@three +!say : polite  <- order(table).
@words +!say : chatty  <- order(words).
@blank +!say : silent  <- order(blank).
