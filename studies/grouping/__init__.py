"""Study: how often diagnosis groups failures correctly, with one and two faults (docs/studies/localization.md)."""
