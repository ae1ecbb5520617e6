"""One self-contained HTML page about runs: tables, settings and interactive plots, which needs no network."""
