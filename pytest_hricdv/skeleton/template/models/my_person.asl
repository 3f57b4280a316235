// What a person does. Each label (@single) is a plan to be covered; actions become the commands of the test.
@single  +!visit : one_wish   <- !wish.
@double  +!visit : two_wishes <- !wish; !wish.

@distant +!wish : keeps_away <- ask; wait_done.
@nosy    +!wish : comes_near <- ask; come_near; go_away; wait_done.
