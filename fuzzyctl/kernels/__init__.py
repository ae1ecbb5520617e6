"""Numbers: a model becomes a flat plan, the plan a straight-line program, and each backend only prints that program."""
