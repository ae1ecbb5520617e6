"""Branch and bound over boxes of inputs, with interval enclosures of the outputs."""
