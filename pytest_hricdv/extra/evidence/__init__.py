"""Evidence: files that document the tests of each requirement, to be signed and archived, and their verification."""
