"""Coverage of the tests: code, plans, requirements and cross products, and the gaps that are left."""
