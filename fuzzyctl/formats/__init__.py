"""Formats that a fuzzy system is written in; each file has `dumps`, from model to text."""
