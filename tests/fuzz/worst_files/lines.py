"""Worst cases of lines: blank, long, broken and unknown ones."""

from worst_files.case import HEAD, case, cut, repeated, repetitions

repetitions(
    {
        "blank-lines": ("\n", HEAD),
        "blank-lines-in-a-parenthesis": ("\n", HEAD, "if (x is low"),
        "spaces-in-a-line": (" ", HEAD, "if x is low"),
        "spaces-before-each-line": (" " * 1000 + "\n" + " " * 1000 + "@\n", HEAD),
        "open-parentheses": ("(", HEAD, "if "),
        "an-open-parenthesis-on-each-line": ("a@ (\n", HEAD),
        "statements-with-an-open-parenthesis": ("param p@ = (1\n", HEAD),
        "quotes": ('"', HEAD, "source "),
        "unclosed-quotes": ('source "a\n', HEAD),
        "comments": ("# comment @\n", HEAD),
        "unknown-lines": ("nonsense @\n", HEAD),
        "unknown-keywords": ("imput a@ in [0, 1]\n  terms a b\n", HEAD),
        "one-line-of-words": ("word@ ", HEAD),
        "one-line-of-one-word": ("w", HEAD),
        "one-line-of-digits": ("1", HEAD, "param p = "),
        "one-line-of-signs": ("-", HEAD, "param p = "),
        "sources": ('source "a book @"\n', HEAD, "if x is low then y is small\n"),
        "a-long-source": ("a book @ ", HEAD, "if x is low then y is small\n", 'source "'),
        "rows-without-a-table": ("low | small\n", HEAD),
        "rows-without-a-bar": ("low small large\n", HEAD, "table y = x\n  low high\n"),
        "allow-lines": ('allow FZ2@ FZ208 "because"\n', HEAD, "if x is low then y is small\n"),
        "combining-marks": ("á̧̧", HEAD, "param "),
    }
)

#: What another tool writes: a line with this number of mistakes is repaired.
FOREIGN = "if x is low && x is high || x is low && x is high then y is small;   % of what another tool writes\n"


@case
def foreign_lines_below_many_params(size):
    yield cut(repeated("param p@ = 1\n", HEAD), 0.95 * size)
    yield int(400 * size) * FOREIGN


@case
def foreign_lines_below_rules_with_groups(size):
    yield HEAD + int(8000 * size) * "if x is (low or high) then y is small\n" + int(400 * size) * FOREIGN
