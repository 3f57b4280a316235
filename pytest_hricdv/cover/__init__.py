"""What the tests reached: code, plans, assertions, cross products, and the closure over all of them."""
