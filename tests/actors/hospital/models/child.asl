// A curious child peeks through the door, and goes away when it is closed, or after a while.
@curious +!play : curious <- peek; !look; go_away.
@calm    +!play <- .wait(10).
@looks   +!look : tidy <- .wait({+closed}, 20000, _).
@bored   +!look <- .wait(2000).
