// Drives a car with a web page on a phone: at full throttle, with a page that is reloaded, closed, or sends what it should not.
@once  +!visit : one_drive  <- !drive.
@twice +!visit : two_drives <- !drive; !drive.
@leaves  +!drive : leaves  <- send(half); close_page; open_page.
@fast    +!drive : fast    <- send(much); send(left); send(zero).
@odd     +!drive : odd     <- send(half); send(null); send(zero).
@cut_off +!drive : cut_off <- send(half); send(broken); open_page.
@reloads +!drive : reloads <- send(half); close_page; open_page; send(zero).
