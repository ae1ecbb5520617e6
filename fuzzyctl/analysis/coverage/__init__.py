"""Coverage: whether some rule fires at every point of the input space."""
