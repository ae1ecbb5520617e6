"""Support for all other packages: arguments, files and terminals."""
