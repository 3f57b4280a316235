"""What everything else stands on: messages of errors, input files, atomic files, grammars."""
