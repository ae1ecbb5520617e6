"""The Python backend: source text for single points."""
