"""What an editor asks of rule files: symbols, completion, hover, fixes; answers are offsets and texts, no protocol."""
