"""Identifiers of target languages: names of a rule file, which may be Greek, made valid and unique."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Final

from fuzzyctl.codegen.c_library import LIBRARY, LINKED
from fuzzyctl.diagnostics.transliterate import in_ascii


def _words(text: str) -> frozenset[str]:
    return frozenset(text.split())


def _headed(head: str, text: str) -> frozenset[str]:
    return frozenset(head + word for word in text.split())


#: What generated C calls its parameters and variables beside inputs, and the one macro that has no name of its system.
_C_OWN: Final = _words(
    "state outputs status result rates step bits cell found next lower upper rate dt k off refused consequent VECTORS"
)
#: Keywords of C99 to C23 and C++, since headers are read by both, names of the library, and those of generated text.
C_RESERVED: Final = (
    _words(
        """
        alignas alignof and and_eq asm auto bitand bitor bool break case catch char class compl concept const
        const_cast constexpr continue decltype default delete do double dynamic_cast else enum explicit export
        extern false float for friend goto if inline int long mutable namespace new noexcept not not_eq nullptr
        operator or or_eq private protected public register reinterpret_cast requires restrict return short signed
        sizeof static static_assert static_cast struct switch template this thread_local throw true try typedef
        typeid typename typeof typeof_unqual union unsigned using virtual void volatile wchar_t while xor xor_eq
        """
    )
    | LIBRARY
    | _C_OWN
)

#: What a function must not be called, besides: names that the linker knows, and variables of the self-test.
C_FUNCTION_RESERVED: Final = C_RESERVED | LINKED | _words("inputs expected tolerance failures worst v wanted none size")

_ENDED: Final = (
    "action case class configuration for function function_block if interface method namespace program repeat resource "
    "step struct transition type var while"
)
#: Keywords, standard functions and their parameters of IEC 61131-3, editions 2 and 3; its names know no case.
_ST_WORDS: Final = _words(
    """
    abs abstract acos action add and andn any array asin at atan atan2 bool by byte cal calc calcn case cd cdt char
    class clk concat configuration constant continue cos ctd ctu ctud cu cv d date date_and_time delete dint
    div do ds dt dword else elsif en eno eq et exit exp expt extends f_edge f_trig false final find for from function
    function_block ge gt if implements in initial_step insert int interface internal interval is_valid jmp jmpc jmpcn
    jmpnc l ld ldate ldate_and_time ldn ldt le left len limit lint ln log lower_bound lreal lt ltime ltime_of_day ltod
    lword max method mid min mod move mul mux n namespace ne neg non_retain not null of on or orn overlap override p
    pointer priority private program protected pt public pv q q1 qd qu r r1 r_edge r_trig read_only read_write real ref
    ref_to release repeat replace resource ret retain retc retcn return right rol ror rs s s1 sd sel sema shl shr sin
    single sint sl sqrt sr st step stn string struct sub super tan task then this time time_of_day to tod tof ton tp
    transition true trunc type udint uint ulint until upper_bound using usint var var_access var_config var_external
    var_global var_in_out var_input var_output var_temp wchar while with word wstring xor xorn error
    """
)
ST_RESERVED: Final = (
    _ST_WORDS
    | _headed("end_", _ENDED)
    | _headed("any_", "bit char chars date derived duration elementary int magnitude num real signed string unsigned")
)

#: Words of Python, and what a module calls its own values beside inputs.
PYTHON_RESERVED: Final = _words(
    """
    and as assert async await break case class continue def del elif else except false finally for from global
    if import in is lambda match none nonlocal not or pass raise return true try type while with False None True
    abs float range print sum math sys main inf nan state result divide smaller larger held power sqrt exp decay
    log sin cos tan atan2 floor fmod as_number evaluate init rates INPUTS OUTPUTS NoRuleFires len zip ArithmeticError
    OverflowError ValueError
    """
)

#: What a function must not be called, besides: variables of the function `main`, which calls it.
PYTHON_FUNCTION_RESERVED: Final = PYTHON_RESERVED | _words("arguments values value point name error")

#: Words of JavaScript in modules, and what a module calls its own values beside inputs.
JAVASCRIPT_RESERVED: Final = _words(
    """
    arguments as async await break case catch class const continue debugger default delete do else enum eval export
    extends false finally for from function get if implements import in instanceof interface let new null of package
    private protected public return set static super switch this throw true try typeof undefined var void while with
    yield NaN Infinity Math Number Float64Array Array Object Error TypeError RangeError NoRuleFiresError
    inputs outputs period params given state dt rate name key value result require_number find quadrature
    divide smaller larger clip held power sqrt exp log sin cos tan atan2 abs floor fmod
    """
)

#: What a function must not be called, besides: `then` makes a promise of a module, and the self-test has variables.
JAVASCRIPT_FUNCTION_RESERVED: Final = JAVASCRIPT_RESERVED | _words(
    "then vectors tolerance worst compare vector output round failures wanted off found refused error console process"
)

#: What generated text calls its own values: arguments, values, tables.
_OWN: Final = re.compile(r"(r?[vstxcku]|r|rate|consequent|result|held)\d+(_.*)?$|c$", re.IGNORECASE)
#: What tells names of a rule file from those.
_SUFFIXED: Final = re.compile(r"_fz(_\d+)?$")


class Names:
    """Give out identifiers, each once.

    Greek letters are spelt out, accents dropped, and what is left outside ASCII becomes `uXXXX`; a name that the
    language reserves, or that generated text may use, gets a final `_fz`, which no name of generated text has; one that
    is taken `_2`, `_3`, ... (IEC 61131-3 has no final underscores).

    Args:
        reserved: Names that must not be given out.
        fold: Whether the language knows no case.
    """

    def __init__(self, reserved: Iterable[str], *, fold: bool = False) -> None:
        self._reserved, self._fold = frozenset(reserved), fold
        self._taken: set[str] = set()

    def claim(self, name: str, *, apart_from: tuple[str, ...] = ()) -> str:
        """Return the identifier for a name, which nothing else gets.

        Args:
            name: As the rule file has it.
            apart_from: With which generated text begins names of its own.
        """
        wanted = ascii_name(name)
        while self._is_kept(wanted, apart_from):
            wanted += "_fz"
        found, number = wanted, 1
        while self._key(found) in self._taken or self._is_kept(found, apart_from):
            number += 1
            found = f"{wanted}_{number}"
        self._taken.add(self._key(found))
        return found

    def _is_kept(self, name: str, apart_from: tuple[str, ...]) -> bool:
        if self._key(name) in self._reserved or name in self._reserved:
            return True
        return not _SUFFIXED.search(name) and bool(_OWN.match(name) or name.startswith(apart_from))

    def _key(self, name: str) -> str:
        return name.lower() if self._fold else name


def ascii_name(name: str) -> str:
    """Return a name in ASCII letters, digits and single underscores, which begins with a letter."""
    text = in_ascii(name)
    # Double, leading and final underscores are reserved in one language or the other.
    text = re.sub(r"_+", "_", text).strip("_") or "name"
    return text if text[0].isalpha() else f"n{text}"
