"""Self-contained HTML page about runs: tables, settings and interactive plots, without network access."""
