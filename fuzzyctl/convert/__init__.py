"""A system written out for people and programs: a Markdown page, a Python module. Neither is read back."""
