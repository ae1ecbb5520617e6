"""Proofs about every reachable step of a controller, by induction over its states."""
