// Drives a car with a web page, and records what it sees for its training: at once, while it drives, or with a page that is reloaded.
@once  +!visit : one_drive  <- !drive.
@twice +!visit : two_drives <- !drive; !drive.
@records +!drive : records      <- send(record); send(half); send(zero); send(pause).
@first   +!drive : drives_first <- send(half); send(record); send(pilot); send(pause); send(zero).
@reloads +!drive : reloads      <- send(half); close_page; open_page; send(record); send(zero); send(pause).
