"""Command line: one file for each command; heavy libraries are imported inside the commands that need them."""
