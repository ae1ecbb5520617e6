"""Files and tables of a run: summaries, reports and data formats."""
