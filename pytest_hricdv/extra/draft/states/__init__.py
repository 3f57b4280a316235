"""State machines of the code, one module for each way to write them."""
