"""Pictures of fuzzy systems: data and axes in, axes out."""
