"""Static analysis of a plan: bounds, proofs of guarantees, coverage, effects of rules and terms."""
