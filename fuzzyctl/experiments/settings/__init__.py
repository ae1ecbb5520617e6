"""Settings: TOML files in layers, overrides of the command line, and the location of each key."""
