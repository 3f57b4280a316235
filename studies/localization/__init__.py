"""How often diagnosis points at the fault: over planted faults and mutants of three testbenches, for docs/diagnosis.md."""
