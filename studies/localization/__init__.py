"""How often diagnosis points at the fault: planted faults and mutants, in three testbenches, for docs/diagnosis.md."""
