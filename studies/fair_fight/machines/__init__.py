"""What a person may do next, as a user writes it for a rule-based machine: phase -> command -> next phase."""
