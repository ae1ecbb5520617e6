"""Published control loops as text: the published numbers next to ours."""
