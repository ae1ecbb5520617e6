"""Properties of fuzzylite that its formats share: versions, functions and degenerate terms."""
