"""Reference trajectories: curves, splines and path files."""
