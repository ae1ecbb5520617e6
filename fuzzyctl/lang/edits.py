"""Edits: text changes as data, and a line under repair."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from functools import cached_property
from itertools import islice
from typing import Final

from fuzzyctl.lang.syntax import NAME, STATEMENT_KEYWORDS

#: A number with its sign, and a formula; signs with a blank only before them begin a cell of their own.
NUMBER: Final = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
VALUE: Final = rf"[-+]?[\w.]+(?:(?:\s*[*/^]\s*|[-+]|\s+[-+]\s+)[\w.(]+\)*)+|[-+]{NAME}"

#: A line that needs more edits of one kind holds no slip.
_MOST: Final = 40

_OPAQUE: Final = re.compile(r'"[^"\n]*"?|#[^\n]*|[“„‟«][^”“»"\n]*[”“»"]?')


@dataclass(frozen=True)
class Edit:
    """Replace the characters from `start` to `end` by a text.

    Args:
        start: Offset of the first character replaced.
        end: Offset after the last one; `start` for an insertion.
        text: The replacement.
        why: The rule of the language behind it, without a full stop.
        sure: Whether it gives the intended text, if the line can be read after it.
    """

    start: int
    end: int
    text: str
    why: str
    sure: bool = True


def _declared(keyword: str, text: str) -> frozenset[str]:
    """Return the names behind a keyword, which may be several, each with its label."""
    lists = re.findall(rf'(?im)^[ \t]*{keyword}[ \t]+(\w+(?:[ \t]*(?:"[^"\n]*"[ \t]*)?,[ \t]*\w+)*)', text)
    return frozenset(name for names in lists for name in re.findall(r"\w+", re.sub(r'"[^"\n]*"', "", names)))


@dataclass(frozen=True)
class Declared:
    """Names that a text declares; each kind is looked for once, on first use."""

    text: str

    @cached_property
    def params(self) -> frozenset[str]:
        """Names of params, as far as their lines look like one."""
        return frozenset(re.findall(r"(?im)^[ \t]*param[ \t]+(\w+)", self.text))

    @cached_property
    def variables(self) -> frozenset[str]:
        """Names of inputs and outputs, as far as their lines look like one."""
        return self.outputs | _declared("input", self.text)

    @cached_property
    def outputs(self) -> frozenset[str]:
        """Names of outputs, as far as their lines look like one."""
        return _declared("output", self.text)

    @cached_property
    def names(self) -> frozenset[str]:
        """Names of params, inputs, outputs and terms, as far as their lines look like declaring one."""
        items = " ".join(re.findall(r"(?im)^[ \t]*terms\b([^\n#]*)", self.text))
        functions = re.findall(r"(?m)^[ \t]*(\w+)[ \t]*=[ \t]*\w+[ \t]*\(", self.text)
        return self.variables | self.params | frozenset((*re.findall(r"(?<![\w@=.])[^\W\d]\w*", items), *functions))

    @cached_property
    def counts(self) -> Counter[str]:
        """How often each word occurs in the text."""
        return Counter(re.findall(NAME, self.text))

    @cached_property
    def words(self) -> dict[str, set[str]]:
        """All words in the lines of each variable, among them its terms."""
        words: dict[str, set[str]] = {}
        variables: list[str] = []
        for line in self.text.split("\n"):
            first, *others = re.findall(NAME, line) or [""]
            if first.lower() in STATEMENT_KEYWORDS and first.lower() != "terms":
                head = re.split(r"\bin\b|[\[(=:]", line)[0] if first.lower() in ("input", "output") else ""
                variables = re.findall(NAME, re.sub(_OPAQUE, "", head))[1:]
            for variable in variables:
                words.setdefault(variable, set()).update((first, *others))
        return words

    @cached_property
    def terms(self) -> frozenset[str]:
        """Names of terms, as far as rules and rows look like naming one."""
        rows = " ".join(re.findall(r"\|([^\n#]*)", self.text))
        ruled = re.findall(r"\bis\s+(?:not\s+)?(\w+)", self.text)
        return frozenset((*ruled, *re.findall(r"(?<![\w(*])\w+", rows)))


@dataclass(frozen=True)
class Surroundings:
    """The facts of the file around a line that a repair may use.

    Args:
        declared: The names that the whole text declares.
        above: The last rule above the line, after those to which it is the `else`.
        statement: The last statement above the line, whose block may go on; an empty string if it does not exist.
        is_first: Whether the line is the first one below it.
        in_block: The first word of the controller, plant or loop that the line belongs to; empty for none.
    """

    declared: Declared
    above: tuple[str, ...] = ()
    statement: str = ""
    is_first: bool = False
    in_block: str = ""

    @property
    def block(self) -> str:
        """The first word of the statement above, in small letters."""
        return self.statement.split(maxsplit=1)[0].lower() if self.statement else ""


#: A repair: the edits that it makes of a line, which it sees with its texts and comments masked, and in full.
Repair = Callable[[str, str, Surroundings], Iterable[Edit]]


#: Makes the replacement of a match of its groups; None if it has no replacement.
Replacement = Callable[["list[str]", Surroundings], "str | None"]


def row(
    pattern: str, new: str | dict[str, str] | Replacement, why: str, *, heads: str = "", sure: bool = True
) -> Repair:
    """Return the repair of all matches of a pattern.

    Args:
        pattern: A regular expression.
        new: The replacement, with `{1}` for the first group, one for each named group, or a function of all groups.
        why: The rule of the language behind it.
        heads: First words of the lines that it concerns; all lines if empty.
        sure: Whether the replacement is the intended text.
    """
    form = re.compile(pattern, re.IGNORECASE | re.MULTILINE)
    words = frozenset(heads.split())

    def repair(code: str, text: str, around: Surroundings) -> Iterator[Edit]:
        for m in form.finditer(code) if not words or head(code) in words else ():
            name: str | int = next((n for n in form.groupindex if m[n] is not None), 0)
            start, end = m.span(name)
            groups = [text[m.start(i) : m.end(i)] if m.start(i) >= 0 else "" for i in range(form.groups + 1)]
            meant = new[str(name)] if isinstance(new, dict) else new
            result = meant.format(*groups) if isinstance(meant, str) else meant(groups, around)
            if result is not None and result != text[start:end]:
                yield Edit(start, end, result, why, sure)

    return repair


def head(code: str) -> str:
    """Return the first word of a line in small letters."""
    word = re.match(rf"\s*({NAME})", code)
    return word[1].lower() if word else ""


def depth(code: str) -> int:
    """Return how many parentheses and brackets are open behind a text."""
    return len(re.findall(r"[(\[]", code)) - len(re.findall(r"[)\]]", code))


def masked(text: str) -> str:
    """Return a text of the same length in which texts and comments hold nothing that a repair could match."""
    return _OPAQUE.sub(lambda m: m[0][0] + "\x01" * (len(m[0]) - 2) + (m[0][-1] if len(m[0]) > 1 else ""), text)


def _whole(origin: list[int], ends: list[int], start: int, end: int) -> tuple[int, int]:
    """Return a range of characters with the rest of those edits that made its first and its last one."""
    if start == end:
        return start, end
    while start > 0 and (origin[start - 1], ends[start - 1]) == (origin[start], ends[start]):
        start -= 1
    while end < len(ends) and (origin[end], ends[end]) == (origin[end - 1], ends[end - 1]):
        end += 1
    return start, end


def _is_replaced(done: Edit, first: int, last: int, inserted: set[int]) -> bool:
    """Whether an earlier edit is a part of one from `first` to `last`, which has what was inserted at some places."""
    if done.start == done.end:
        return first < done.start < last or done.start in inserted
    return first <= done.start and done.end <= last


@dataclass
class Draft:
    """A line under repair.

    Args:
        text: Its text so far.
        origin: For each of its characters, and for its end, the offset in the original text.
        ends: For each of its characters the offset after its place in the original.
        edits: The changes, by offsets in the original.
    """

    text: str
    origin: list[int]
    ends: list[int]
    edits: list[Edit] = field(default_factory=list)

    def edited(self, edits: Iterable[Edit]) -> Draft:
        """Return the line after further edits, which do not overlap."""
        text, origin, ends, done = self.text, list(self.origin), list(self.ends), list(self.edits)
        for e in sorted(edits, key=lambda e: (e.start, e.end), reverse=True):
            start, end = _whole(origin, ends, e.start, e.end)
            first = origin[start]
            last = ends[end - 1] if end > start else first
            new = text[start : e.start] + e.text + text[e.end : end]
            # An edit of a range that was edited before replaces those edits.
            inserted = {at for at, stop in zip(origin[start:end], ends[start:end], strict=True) if at == stop}
            before = [d for d in done if _is_replaced(d, first, last, inserted)]
            done = [d for d in done if d not in before]
            # A change inside of a larger edit is a part of that.
            why = before[0].why if before and (start, end) != (e.start, e.end) else e.why
            done.append(Edit(first, max(first, last), new, why, e.sure and all(d.sure for d in before)))
            text = text[:start] + new + text[end:]
            origin[start:end] = [first] * len(new)
            ends[start:end] = [max(first, last)] * len(new)
        return Draft(text, origin, ends, done)

    def before_comment(self) -> tuple[Draft, Draft]:
        """Return the code of the line, with all edits, and its comment with the blanks before it."""
        at = masked(self.text).find("#")
        at = len(self.text if at < 0 else self.text[:at].rstrip())
        code = Draft(self.text[:at], self.origin[: at + 1], self.ends[:at], self.edits)
        return code, Draft(self.text[at:], self.origin[at:], self.ends[at:])

    def followed_by(self, rest: Draft) -> Draft:
        """Return the line with the text after it."""
        return Draft(self.text + rest.text, self.origin[:-1] + rest.origin, self.ends + rest.ends, self.edits)

    def repaired_by(self, repair: Repair, around: Surroundings) -> Draft:
        """Return the line after a repair; itself where the repair finds nothing."""
        edits = list(islice(repair(masked(self.text), self.text, around), _MOST + 1))
        return self.edited(edits) if 0 < len(edits) <= _MOST else self
