"""Diagnostics: source texts with locations, codes, suggestions and their rendering."""
