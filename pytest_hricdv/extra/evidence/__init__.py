"""Evidence: what a report shows for each requirement, in files for those who have to sign, and their verification."""
