// The porter opens the door, and a tidy one closes it again and tells the child to go.
@tidy +!serve : tidy <- open; rest; close; .send(child, tell, closed).
@lazy +!serve <- rest; open.
