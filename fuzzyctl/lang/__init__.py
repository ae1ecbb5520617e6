"""Text of rule files and its syntax tree: no meaning, no numbers."""
