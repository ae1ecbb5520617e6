"""Published control loops as text: what was printed beside what comes out."""
