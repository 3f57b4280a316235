"""What the tests covered: code, plans, requirements and cross products, and what no test covers."""
