// The cart, as it should be: it says once that it has come to the end, and does not while the child stands there.
!deliver.

@arrives +!deliver : not in_the_way <- arrive.
@waits   +!deliver <- .wait({+free_again}); -in_the_way[source(percept)]; -free_again[source(percept)]; !deliver.
