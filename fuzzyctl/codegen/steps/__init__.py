"""Steps of controllers as source text."""
