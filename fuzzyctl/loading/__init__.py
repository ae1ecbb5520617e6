"""Loading: from a path to a checked system."""
