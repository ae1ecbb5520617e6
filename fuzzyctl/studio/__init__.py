"""What the studio in the browser asks of a text, as plain data, and the server of its folder; no numpy."""
