// Walks in front of a cart that follows; leaves the picture, stands still, or the camera stops working.
@once  +!visit : one_walk  <- !walk; !part.
@twice +!visit : two_walks <- !walk; !walk; !part.
@far    +!walk : walks_far   <- walk(far).
@near   +!walk : stays_near  <- walk(near).
@middle +!walk : keeps_off   <- walk(middle).
@aside  +!walk : goes_aside  <- walk(aside).
@covers +!part : covers_lens <- walk(far); cover_lens.
@hides  +!part : walks_off   <- walk(far); hide.
@stays  +!part <- walk(near).
