"""Resolution of settings: norms, implication, aggregation, activation, defuzzifier, semantics."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import fields, replace
from typing import Any, Final, TypeVar, get_args, get_type_hints

from fuzzyctl import expr as ex
from fuzzyctl.diagnostics.fixes import respelt, respelt_as_suggested
from fuzzyctl.diagnostics.suggestions import closest, did_you_mean
from fuzzyctl.formulas import AGGREGATIONS, CONJUNCTIONS, DISJUNCTIONS, IMPLICATIONS
from fuzzyctl.lang import syntax as sx
from fuzzyctl.model.method import ACTIVATIONS, DEFUZZIFIERS, KNOBS, Activation, Defuzzifier, Method, Semantics
from fuzzyctl.model.profiles import PROFILES, UNSET
from fuzzyctl.model.rule import Rule, RuleBlock, RuleTable
from fuzzyctl.model.variable import Output
from fuzzyctl.resolve.context import Context

_FIELDS: Final[dict[str, tuple[str, tuple[str, ...]]]] = {
    "and": ("conjunction", tuple(CONJUNCTIONS)),
    "or": ("disjunction", tuple(DISJUNCTIONS)),
    "implication": ("implication", tuple(IMPLICATIONS)),
    "aggregation": ("aggregation", tuple(AGGREGATIONS)),
    "defuzzifier": ("defuzzifier", tuple(DEFUZZIFIERS)),
}

#: Largest number of rules that an activation method lets act.
MOST_RULES: Final = 1_000_000

_Option = TypeVar("_Option", sx.Option, sx.ActivationOption)

#: Settings with the values that each may have.
SETTINGS: Final = {keyword: known for keyword, (_, known) in _FIELDS.items()}

#: Options of the activation methods.
_OPTIONS: Final[dict[str, tuple[str, ...]]] = {
    "general": (),
    "first": ("count", "threshold"),
    "last": ("count", "threshold"),
    "highest": ("count",),
    "lowest": ("count",),
    "proportional": (),
    "threshold": ("<", "<=", "==", "!=", ">=", ">"),
}


def resolve_method(context: Context, statements: Sequence[sx.Statement]) -> Method:
    """Resolve all settings of a system; those that it shares with others may have no effect here."""
    chosen: dict[str, sx.Word] = {}
    values: dict[str, Any] = {"defuzzifier": context.profile.defuzzifier("centroid")}
    for s in statements:
        match s:
            case sx.Setting(keyword=keyword) if context.is_first(keyword, chosen):
                resolve_own_setting(context, s, values)
            case sx.Activation(keyword=keyword) if context.is_first(keyword, chosen):
                values |= {"activation": _activation(context, s), "span": keyword.span}
    spans = {word: keyword.span for word, keyword in chosen.items()}
    return replace(context.profile.method, spans=spans, **values)


def resolve_rule_settings(context: Context, statement: sx.Rules) -> dict[str, Any]:
    """Resolve the settings of a rule block into fields of it."""
    chosen: dict[str, sx.Word] = {}
    values: dict[str, Any] = {}
    for s in statement.settings:
        if not context.is_first(s.keyword, chosen):
            continue
        if isinstance(s, sx.Activation):
            values["activation"] = _activation(context, s)
        else:
            resolve_own_setting(context, s, values)
    return values


def find_idle_settings(
    context: Context,
    statements: Sequence[sx.Statement],
    shared: Sequence[sx.Statement],
    method: Method,
    outputs: Sequence[Output],
    blocks: Sequence[RuleTable | Rule | RuleBlock] = (),
) -> None:
    """Warn of implications and aggregations without effect, since outputs sum over rules or have others.

    Args:
        context: Where warnings go.
        statements: All statements of a system.
        shared: Those of them that other systems share, in which they may have an effect.
        method: The method that follows from them.
        outputs: The outputs.
        blocks: The rules; a block may have another implication, so that other settings do not apply.
    """
    kinds = {o.name: o.defuzzifier or method.defuzzifier for o in outputs}
    joins = method.semantics.joins_rules
    implied = _implied_elsewhere(blocks)
    named = {b.name: b for b in reversed(blocks) if isinstance(b, RuleBlock)}
    for s in statements:
        if isinstance(s, sx.Setting) and s not in shared and _may_be_idle(s, joins):
            heeding = [o for o in outputs if not kinds[o.name].over_rules and getattr(o, s.keyword.text) is None]
            if s.keyword.text == "implication":
                heeding = [o for o in heeding if o.name not in implied]
            if outputs and not heeding:
                _idle(context, s, kinds[outputs[0].name], method)
        elif isinstance(s, sx.Rules):
            _find_idle_implication(context, s, kinds, named, method)
        elif isinstance(s, sx.Variable) and s.name.text in kinds and kinds[s.name.text].over_rules:
            clauses = [c.setting for c in s.clauses if isinstance(c, sx.SettingClause)]
            for setting in (s for s in clauses if _may_be_idle(s, joins)):
                _idle(context, setting, kinds[s.name.text], method)
        elif isinstance(s, sx.Variable) and s.name.text in implied:
            for c in s.clauses:
                if isinstance(c, sx.SettingClause) and c.setting.keyword.text == "implication":
                    message = "'implication' has no effect: every rule block that sets the output has its own"
                    context.report("FZ214", message, c.span, help="remove it", warning=True)


def _implied_elsewhere(blocks: Sequence[RuleTable | Rule | RuleBlock]) -> set[str]:
    """Return the outputs that are set only by rule blocks with an implication."""
    outputs: set[str] = set()
    others: set[str] = set()
    for b in blocks:
        has_own = isinstance(b, RuleBlock) and b.implication is not None
        (outputs if has_own else others).update(_set_by(b))
    return outputs - others


def _set_by(block: RuleTable | Rule | RuleBlock) -> set[str]:
    parts = block.rules if isinstance(block, RuleBlock) else (block,)
    tables = {o for p in parts if isinstance(p, RuleTable) for o in p.outputs}
    return tables | {c.output for p in parts if isinstance(p, Rule) for c in p.consequents}


def _find_idle_implication(
    context: Context,
    head: sx.Rules,
    kinds: Mapping[str, Defuzzifier],
    blocks: Mapping[str, RuleBlock],
    method: Method,
) -> None:
    """Warn of the implication of a rule block that sets no output which looks at sets."""
    joins = method.semantics.joins_rules
    setting = next((s for s in head.settings if isinstance(s, sx.Setting) and _may_be_idle(s, joins)), None)
    if setting is None:
        return
    rules = blocks.get(head.name.text)
    reached = [kinds[name] for name in sorted(_set_by(rules)) if name in kinds] if rules is not None else []
    if reached and all(kind.over_rules for kind in reached):
        _idle(context, setting, reached[0], method)


def _may_be_idle(s: sx.Setting, joins: bool) -> bool:
    """Return whether it is a setting of sets that has a meaning; one without has a diagnostic already."""
    idle = ("implication",) if joins else ("implication", "aggregation")
    return s.keyword.text in idle and s.value.text in _FIELDS[s.keyword.text][1]


def _idle(context: Context, setting: sx.Setting, defuzzifier: Defuzzifier, method: Method) -> None:
    reason = f"'{defuzzifier.kind}' sums over rules" if defuzzifier.over_rules else "every output has its own"
    help_text = "remove it, or take 'defuzzifier centroid'" if defuzzifier.over_rules else "remove it"
    message = f"'{setting.keyword.text}' has no effect: {reason}"
    place = method.spans.get("defuzzifier") if defuzzifier.over_rules and defuzzifier == method.defuzzifier else None
    note = (place, "the defuzzifier is given here") if place is not None else None
    context.report("FZ214", message, setting.keyword.span, help=help_text, note=note, warning=True)


def resolve_own_setting(context: Context, s: sx.Setting, values: dict[str, Any]) -> bool:
    """Resolve one setting of a system or of an output into the field it sets; False when it has no meaning."""
    field, choices = _FIELDS[s.keyword.text]
    if s.value.text not in choices:
        context.report(
            "FZ213",
            f"'{s.keyword.text}' knows no '{s.value.text}'",
            s.value.span,
            facts=(f"one of: {', '.join(choices)}",),
            help=did_you_mean(s.value.text, choices),
            fix=respelt_as_suggested(s.value.span, s.value.text, choices),
        )
        return False
    before = len(context.diagnostics)
    if field == "defuzzifier":
        values[field] = _defuzzifier_in_force(context, s)
    else:
        _no_options(context, s)
        values[field] = s.value.text
    return len(context.diagnostics) == before


def _once(context: Context, options: Sequence[_Option]) -> Iterator[_Option]:
    """Yield the options, each name once; comparisons are one option, whatever their sign."""
    seen: dict[str, sx.Word] = {}
    for option in options:
        if context.is_first(option.name, seen, "" if option.name.text.isidentifier() else "a comparison"):
            yield option


def _no_options(context: Context, setting: sx.Setting) -> None:
    for option in setting.options:
        context.report("FZ213", f"'{setting.value.text}' takes no options", option.name.span, help="remove it")


def _defuzzifier_in_force(context: Context, setting: sx.Setting) -> Defuzzifier:
    """Return a defuzzifier with the options that are not given from the profile in force."""
    options = [o for o in setting.options if UNSET.get(o.name.text) != o.value.text]
    names = [o.name.text for o in setting.options]
    base = context.profile.defuzzifier(setting.value.text)
    if "resolution" in names and "resolution" not in [o.name.text for o in options]:
        base = Defuzzifier(kind=base.kind)
    elif base.resolution is not None and options and "resolution" not in names:
        at = setting.value.span
        options.append(sx.Option(sx.Word("resolution", at), sx.Word(str(base.resolution), at)))
    defuzzifier = resolve_options(context, setting.value.text, _once(context, options))
    settable = {f.name for f in fields(defuzzifier)} - {"kind"}
    return replace(base, **{name: getattr(defuzzifier, name) for name in names if name in settable})


def _activation(context: Context, s: sx.Activation) -> Activation:
    kind = s.kind.text
    if kind not in ACTIVATIONS:
        context.unknown("activation method", s.kind, ACTIVATIONS, "FZ213")
        return Activation()
    before = len(context.diagnostics)
    values: dict[str, Any] = {"kind": kind, "span": s.kind.span}
    for option in _once(context, s.options):
        name = option.name.text
        if name not in _OPTIONS[kind]:
            context.unknown("option", option.name, _OPTIONS[kind], "FZ213")
        elif not context.check_names(option.value, context.params, "param"):
            continue
        elif name == "count":
            values["count"] = _count(context, option)
        elif name == "threshold":
            values["threshold"] = option.value
        else:
            values |= {"comparison": name, "threshold": option.value}
    missing = _missing(kind, values)
    if missing:
        # An option with a mistake may be the one that is missing.
        if len(context.diagnostics) == before:
            help_text = f"write, for example: {_FORM[kind]}"
            context.report("FZ303", f"activation '{kind}' needs {missing}", s.kind.span, help=help_text)
        return Activation()
    return Activation(**values)


_FORM: Final = {
    "first": "activation first(count=1, threshold=0)",
    "last": "activation last(count=1, threshold=0)",
    "highest": "activation highest(count=1)",
    "lowest": "activation lowest(count=1)",
    "threshold": "activation threshold(>= 0.1)",
}


def _missing(kind: str, fields: dict[str, Any]) -> str:
    if kind in ("first", "last", "highest", "lowest") and "count" not in fields:
        return "a count"
    return "a comparison" if kind == "threshold" and "comparison" not in fields else ""


def _count(context: Context, option: sx.ActivationOption) -> int:
    value = option.value
    if isinstance(value, ex.Number) and value.value == int(value.value) and 1 <= value.value <= MOST_RULES:
        return int(value.value)
    message = f"count = {ex.to_text(value)} is not a whole number from 1 to {MOST_RULES}"
    context.report("FZ302", message, ex.span_of(value) or option.name.span)
    return 1


#: Bounds of the number of samples of a set.
RESOLUTIONS: Final = (2, 1_000_000)


def resolve_options(context: Context, kind: str, options: Iterable[sx.Option]) -> Defuzzifier:
    """Return a defuzzifier with its options, each given at most once; report those without a meaning."""
    forms = DEFUZZIFIERS[kind].options
    by_name: dict[str, sx.Option] = {}
    fields: dict[str, Any] = {}
    for option in options:
        name = option.name.text
        if not forms:
            context.report("FZ213", f"'{kind}' takes no options", option.name.span, help="remove it")
        elif name not in forms:
            context.unknown("option", option.name, tuple(forms), "FZ213")
        else:
            by_name[name] = option
            value = _value(context, option, forms[name])
            if value is not None:
                fields[name] = value
    _require_samples(context, kind, by_name)
    return Defuzzifier(kind=kind, **fields)


def _value(context: Context, option: sx.Option, words: tuple[str, ...]) -> str | int | float | None:
    """Return the value of an option, None where it has been reported."""
    text, span = option.value.text, option.value.span
    match option.name.text:
        case "resolution":
            low, high = (1, RESOLUTIONS[1]) if context.foreign else RESOLUTIONS
            if text.isdecimal() and low <= int(text) <= high:
                return int(text)
            context.report("FZ302", f"resolution = {text} is not a whole number from {low} to {high}", span)
        case "tolerance":
            value = _number(text)
            if 0.0 <= value < 1.0:
                return value
            message = f"tolerance = {text} is not a number from 0 up to 1"
            context.report("FZ302", message, span, help="it is a part of the largest degree, such as 1e-9")
        case name if text not in words:
            context.report("FZ213", f"no {name} '{text}'", span, facts=(f"one of: {', '.join(words)}",))
        case _:
            return text
    return None


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return math.nan


def _require_samples(context: Context, kind: str, given: dict[str, sx.Option]) -> None:
    for name in ("grid", "rule"):
        if name in given and "resolution" not in given and given[name].value.text != "polygon":
            what = "has no grid" if name == "grid" else "needs no rule"
            example = f"{kind}(resolution=1000, {name}={given[name].value.text})"
            message = f"'{name}' needs 'resolution': the exact {kind} {what}"
            context.report("FZ214", message, given[name].name.span, help=f"write, for example, {example}")


_TYPES: Final = get_type_hints(Semantics)
#: The words of each knob; empty for a number.
CHOICES: Final[dict[str, tuple[str, ...]]] = {
    name: tuple(word for word in get_args(_TYPES[name]) if isinstance(word, str)) for name in KNOBS
}

#: Knobs that are numbers.
NUMBERS: Final = tuple(name for name, words in CHOICES.items() if not words)


def resolve_semantics(context: Context, statements: Sequence[sx.Statement]) -> Semantics:
    """Resolve the semantics of a system, and enter the profile in force into the context."""
    choices = [s for s in statements if isinstance(s, sx.Semantics)]
    if not choices:
        return context.profile.semantics
    first, *rest = choices
    for again in rest:
        context.is_first(again.keyword, {"semantics": first.keyword})
    if first.profile.text not in PROFILES:
        context.unknown("profile", first.profile, PROFILES, "FZ213")
    else:
        context.profile = PROFILES[first.profile.text]
    semantics = context.profile.semantics
    return replace(semantics, **_knobs(context, first.options), span=first.profile.span)


def _knobs(context: Context, options: Sequence[sx.Option]) -> dict[str, Any]:
    """Resolve the knobs that are given."""
    values: dict[str, Any] = {}
    seen: dict[str, sx.Word] = {}
    for option in options:
        name, word = option.name.text, option.value
        if not context.is_first(option.name, seen):
            continue
        if name not in KNOBS:
            context.unknown("knob", option.name, KNOBS, "FZ213")
        elif name in NUMBERS:
            _knob_number(context, name, word, values)
        elif word.text not in CHOICES[name]:
            near = closest(word.text, CHOICES[name])
            facts = (f"one of: {', '.join(CHOICES[name])}",)
            help_text = f"did you mean '{near}'?" if near else ""
            fix = respelt(word.span, word.text, near, CHOICES[name])
            context.report("FZ213", f"'{name}' knows no '{word.text}'", word.span, facts=facts, help=help_text, fix=fix)
        else:
            values[name] = word.text
    return values


def _knob_number(context: Context, name: str, word: sx.Word, values: dict[str, Any]) -> None:
    """Resolve a knob that is a number; `least` may be `none` as well."""
    if name == "least" and word.text == "none":
        values[name] = None
        return
    try:
        value = float(word.text)
    except ValueError:
        value = math.nan
    if not 0.0 <= value < 1.0 or word.text[0] not in "0123456789.":
        bound = "no number from 0 to below 1" + (", and not 'none'" if name == "least" else "")
        context.report("FZ302", f"{name} = {word.text} is {bound}", word.span)
    else:
        values[name] = value
