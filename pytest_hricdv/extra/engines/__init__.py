"""Physics engines that check each other."""
