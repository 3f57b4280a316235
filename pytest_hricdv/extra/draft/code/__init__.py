"""The source of a package: parsed, not imported, with what its names, expressions and classes come to."""
