"""Two systems side by side: what was changed, where their numbers differ most, and which setting explains it."""
