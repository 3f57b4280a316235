"""Study: how often diagnosis points at planted faults and mutants (docs/studies/localization.md)."""
