"""Evidence: files that show for each requirement what was tested, to be signed and kept, and their verification."""
