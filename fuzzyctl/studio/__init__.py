"""Answers to the studio in the browser as plain data, and the server of its folder; no numpy."""
