"""Controllers, plants and loops in the tools of others; each package is imported when it is called."""
