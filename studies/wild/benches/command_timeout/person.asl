// Drives with a joystick program that sends commands, and stops sending without a word: a lost link, or a crash.
@once  +!visit : one_drive  <- !drive.
@twice +!visit : two_drives <- !drive; !drive.
@ahead +!drive : ahead <- drive(ahead); leave.
@turns +!drive : turns <- drive(turns); leave.
@curve +!drive : curve <- drive(curve); leave.
@stop  +!drive : stops <- drive(ahead); drive(zero); leave.
