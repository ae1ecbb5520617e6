"""Identifiers of other languages: names of a rule file, which may be Greek, made safe and unique."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable
from typing import Final


def _words_in_order(text: str) -> list[str]:
    return text.split()


def _words(text: str) -> frozenset[str]:
    return frozenset(text.split())


_GREEK: Final = dict(
    zip(
        "αβγδεζηθικλμνξοπρςστυφχψω",
        _words_in_order(
            "alpha beta gamma delta epsilon zeta eta theta iota kappa lambda mu nu xi omicron pi rho sigma sigma "
            "tau upsilon phi chi psi omega"
        ),
        strict=True,
    )
)

#: Keywords of C99, C11 and C++, since headers are read by both, and names of the headers that generated code includes.
C_RESERVED: Final = _words(
    """
    alignas alignof and and_eq asm auto bitand bitor bool break case catch char class compl concept const
    const_cast constexpr continue decltype default delete do double dynamic_cast else enum explicit export
    extern false float for friend goto if inline int long mutable namespace new noexcept not not_eq nullptr
    operator or or_eq private protected public register reinterpret_cast requires restrict return short signed
    sizeof static static_assert static_cast struct switch template this thread_local throw true try typedef
    typeid typename typeof union unsigned using virtual void volatile wchar_t while xor xor_eq acos acosf acosh
    asin asinf asinh atan atan2 atan2f atanf atanh cbrt ceil copysign cos cosf cosh erf erfc exp exp2 expf expm1
    fabs fabsf fdim floor fma fmax fmin fmod frexp hypot ilogb j0 j1 jn ldexp lgamma llrint llround log log10
    log1p log2 logb logf lrint lround modf nan nearbyint nextafter nexttoward pow powf remainder remquo rint
    round scalbln scalbn sin sinf sinh sqrt sqrtf tan tanf tanh tgamma trunc y0 y1 yn signbit isnan isinf
    isfinite signgam memchr memcmp memcpy memmove memset strcat strchr strcmp strcoll strcpy strlen strncmp
    strstr size_t ptrdiff_t printf puts putchar main abort abs exit free malloc calloc realloc index rindex time
    signal raise errno assert int8_t int16_t int32_t int64_t uint8_t uint16_t uint32_t uint64_t linux unix near
    far interrupt state outputs status result rates step bits cell found next lower upper rate dt k off
    """
)

#: Keywords and standard functions of IEC 61131-3; its names know no case.
ST_RESERVED: Final = _words(
    """
    abs acos action add and any array asin at atan atan2 bool by byte case configuration constant continue
    concat cos ctd ctu ctud date delete div do dt dword else elsif end_action end_case end_for end_function
    end_function_block end_if end_program end_repeat end_struct end_type end_var end_while eq exit exp expt
    f_edge f_trig false find for from function function_block ge gt if initial_step insert int interval le left
    len limit lint ln log lreal lt lword max mid min mod move mul mux ne non_retain not null of on or overlap
    pointer program r_edge r_trig read_only read_write real ref ref_to repeat replace resource retain return
    right rol ror rs sel shl shr sin single sint sqrt sr step string struct sub super tan task then this time
    time_of_day to tod tof ton tp transition true trunc type udint uint ulint until usint var var_access
    var_config var_external var_global var_in_out var_input var_output var_temp while with word wstring xor
    error
    """
)

#: Words and names of generated Python.
PYTHON_RESERVED: Final = _words(
    """
    and as assert async await break case class continue def del elif else except false finally for from global
    if import in is lambda match none nonlocal not or pass raise return true try type while with False None True
    abs float range print sum math sys main inf nan state result divide smaller larger held power sqrt exp decay
    log sin cos tan atan2 as_number evaluate init rates INPUTS OUTPUTS NoRuleFires
    """
)

#: What generated text calls its own values: arguments, values, tables, speculated values.
_OWN: Final = re.compile(r"(r?[vstxcku]|r|rate|consequent|result|held)\d+(_.*)?$|c$", re.IGNORECASE)


class Names:
    """Give out identifiers, each once.

    Greek letters are spelt out, accents dropped, and what is left outside ASCII becomes `uXXXX`; a name that the
    language reserves gets a final `_fz`, one that is taken `_2`, `_3`, ... (IEC 61131-3 has no final underscores).

    Args:
        reserved: Names that must not be given out.
        fold: Whether the language knows no case.
    """

    def __init__(self, reserved: Iterable[str], *, fold: bool = False) -> None:
        self._reserved, self._fold = frozenset(reserved), fold
        self._taken: set[str] = set()

    def claim(self, name: str) -> str:
        """Return the identifier for a name, which nothing else gets."""
        wanted = ascii_name(name)
        if self._key(wanted) in self._reserved or wanted in self._reserved or _OWN.match(wanted):
            wanted += "_fz"
        found, number = wanted, 1
        while self._key(found) in self._taken:
            number += 1
            found = f"{wanted}_{number}"
        self._taken.add(self._key(found))
        return found

    def _key(self, name: str) -> str:
        return name.lower() if self._fold else name


def ascii_name(name: str) -> str:
    """Return a name in ASCII letters, digits and single underscores, which begins with a letter."""
    text = "".join(_plain(c) for c in unicodedata.normalize("NFC", name))
    # Double, leading and final underscores are reserved in one language or the other.
    text = re.sub(r"_+", "_", text).strip("_") or "name"
    return text if text[0].isalpha() else f"n{text}"


def _plain(character: str) -> str:
    if character.isascii():
        return character if character.isalnum() else "_"
    base = "".join(c for c in unicodedata.normalize("NFKD", character) if not unicodedata.combining(c))
    if base.isascii() and base.isalnum():
        return base
    if base.lower() in _GREEK:
        spelt = _GREEK[base.lower()]
        return spelt.capitalize() if base != base.lower() else spelt
    return "".join(f"u{ord(c):04X}" for c in character)
