"""Answers on rule files for editors: symbols, completion, hover, fixes, as offsets and texts without a protocol."""
