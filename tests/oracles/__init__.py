"""Readers of other tools' files as they were before they became translations: the numbers that these must have."""
