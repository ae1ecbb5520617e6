"""Proofs about a plan: what a system can return, and where it cannot return anything."""
