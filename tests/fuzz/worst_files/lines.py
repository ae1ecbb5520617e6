"""Worst cases of lines: blank, long, broken and unknown ones."""

from worst_files.case import HEAD, case, repeated


@case
def blank_lines(size):
    yield from repeated("\n", HEAD)


@case
def blank_lines_in_a_parenthesis(size):
    yield from repeated("\n", HEAD, "if (x is low")


@case
def spaces_in_a_line(size):
    yield from repeated(" ", HEAD, "if x is low")


@case
def spaces_before_each_line(size):
    yield from repeated(" " * 1000 + "\n" + " " * 1000 + "@\n", HEAD)


@case
def open_parentheses(size):
    yield from repeated("(", HEAD, "if ")


@case
def an_open_parenthesis_on_each_line(size):
    yield from repeated("a@ (\n", HEAD)


@case
def statements_with_an_open_parenthesis(size):
    yield from repeated("param p@ = (1\n", HEAD)


@case
def quotes(size):
    yield from repeated('"', HEAD, "source ")


@case
def unclosed_quotes(size):
    yield from repeated('source "a\n', HEAD)


@case
def comments(size):
    yield from repeated("# comment @\n", HEAD)


@case
def unknown_lines(size):
    yield from repeated("nonsense @\n", HEAD)


@case
def unknown_keywords(size):
    yield from repeated("imput a@ in [0, 1]\n  terms a b\n", HEAD)


@case
def one_line_of_words(size):
    yield from repeated("word@ ", HEAD)


@case
def one_line_of_one_word(size):
    yield from repeated("w", HEAD)


@case
def one_line_of_digits(size):
    yield from repeated("1", HEAD, "param p = ")


@case
def one_line_of_signs(size):
    yield from repeated("-", HEAD, "param p = ")


@case
def sources(size):
    yield from repeated('source "a book @"\n', HEAD, "if x is low then y is small\n")


@case
def a_long_source(size):
    yield from repeated("a book @ ", HEAD, "if x is low then y is small\n", 'source "')


@case
def rows_without_a_table(size):
    yield from repeated("low | small\n", HEAD)


@case
def rows_without_a_bar(size):
    yield from repeated("low small large\n", HEAD, "table y = x\n  low high\n")


@case
def allow_lines(size):
    yield from repeated('allow FZ2@ FZ208 "because"\n', HEAD, "if x is low then y is small\n")


@case
def combining_marks(size):
    yield from repeated("á̧̧", HEAD, "param ")
