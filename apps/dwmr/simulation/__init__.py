"""The simulation: preflight checks, the compiled loop and its noise."""
