"""Results computed from a trajectory: metrics, Lyapunov functions and derived signals."""
