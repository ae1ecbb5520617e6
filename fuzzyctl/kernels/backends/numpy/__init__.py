"""The numpy backend: source text over arrays."""
