"""One self-contained page of a file: sliders, terms, rules, surfaces, loops, computed by its generated JavaScript."""
