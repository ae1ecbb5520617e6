"""Identifiers of target languages: names of a rule file, which may be Greek, made valid and unique.

Names of the C standard library (C99, with what C11 and C23 add) are reserved, header by header. Macros replace a name
wherever it stands, so no name of a file may be one, those of members included. The compiler's own mode adds names of
POSIX to the headers that generated code includes.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Final

from fuzzyctl.diagnostics.terminal import in_ascii


def _words(text: str) -> frozenset[str]:
    return frozenset(text.split())


def _of_three_types(text: str) -> frozenset[str]:
    return frozenset(name + suffix for name in text.split() for suffix in ("", "f", "l"))


def _sized(*patterns: str) -> frozenset[str]:
    return frozenset(p.replace("#", size) for p in patterns for size in ("8", "16", "32", "64"))


_MATH: Final = _of_three_types(
    """
    acos acosh asin asinh atan atan2 atanh cbrt ceil copysign cos cosh erf erfc exp exp2 expm1 fabs fdim floor fma fmax
    fmin fmod frexp hypot ilogb ldexp lgamma llrint llround log log10 log1p log2 logb lrint lround modf nan nearbyint
    nextafter nexttoward pow remainder remquo rint round scalbln scalbn sin sinh sqrt tan tanh tgamma trunc
    cabs cacos cacosh carg casin casinh catan catanh ccos ccosh cexp cimag clog conj cpow cproj creal csin csinh csqrt
    ctan ctanh
    """
) | _words(
    """
    double_t float_t HUGE_VAL HUGE_VALF HUGE_VALL INFINITY NAN FP_INFINITE FP_NAN FP_NORMAL FP_SUBNORMAL FP_ZERO
    FP_FAST_FMA FP_FAST_FMAF FP_FAST_FMAL FP_ILOGB0 FP_ILOGBNAN MATH_ERRNO MATH_ERREXCEPT math_errhandling fpclassify
    isfinite isinf isnan isnormal signbit isgreater isgreaterequal isless islessequal islessgreater isunordered
    issignaling complex imaginary I j0 j1 jn y0 y1 yn signgam M_E M_LOG2E M_LOG10E M_LN2 M_LN10 M_PI M_PI_2 M_PI_4
    M_1_PI M_2_PI M_2_SQRTPI M_SQRT2 M_SQRT1_2
    """
)
_FLOAT: Final = frozenset(
    f"{kind}_{what}"
    for kind in ("FLT", "DBL", "LDBL")
    for what in _words(
        "MANT_DIG DIG MIN_EXP MIN_10_EXP MAX_EXP MAX_10_EXP MAX EPSILON MIN DECIMAL_DIG TRUE_MIN HAS_SUBNORM"
    )
) | _words("FLT_RADIX FLT_ROUNDS FLT_EVAL_METHOD DECIMAL_DIG")
_INTEGERS: Final = _sized(
    *("int#_t", "uint#_t", "int_least#_t", "uint_least#_t", "int_fast#_t", "uint_fast#_t"),
    *("INT#_MIN", "INT#_MAX", "UINT#_MAX", "INT_LEAST#_MIN", "INT_LEAST#_MAX", "UINT_LEAST#_MAX"),
    *("INT_FAST#_MIN", "INT_FAST#_MAX", "UINT_FAST#_MAX", "INT#_C", "UINT#_C"),
) | _words(
    """
    intptr_t uintptr_t intmax_t uintmax_t INTPTR_MIN INTPTR_MAX UINTPTR_MAX INTMAX_MIN INTMAX_MAX UINTMAX_MAX
    PTRDIFF_MIN PTRDIFF_MAX SIG_ATOMIC_MIN SIG_ATOMIC_MAX SIZE_MAX WCHAR_MIN WCHAR_MAX WINT_MIN WINT_MAX INTMAX_C
    UINTMAX_C CHAR_BIT SCHAR_MIN SCHAR_MAX UCHAR_MAX CHAR_MIN CHAR_MAX MB_LEN_MAX SHRT_MIN SHRT_MAX USHRT_MAX INT_MIN
    INT_MAX UINT_MAX LONG_MIN LONG_MAX ULONG_MAX LLONG_MIN LLONG_MAX ULLONG_MAX imaxabs imaxdiv imaxdiv_t strtoimax
    strtoumax wcstoimax wcstoumax
    """
)
_TEXT: Final = _words(
    """
    size_t ptrdiff_t NULL offsetof max_align_t wchar_t wint_t memchr memcmp memcpy memmove memset memccpy strcat strchr
    strcmp strcoll strcpy strcspn strdup strerror strlen strncat strncmp strncpy strndup strpbrk strrchr strspn strstr
    strtok strxfrm isalnum isalpha isblank iscntrl isdigit isgraph islower isprint ispunct isspace isupper isxdigit
    tolower toupper
    """
)
_FILES: Final = _words(
    """
    FILE fpos_t BUFSIZ EOF FILENAME_MAX FOPEN_MAX L_tmpnam L_ctermid P_tmpdir SEEK_CUR SEEK_END SEEK_SET TMP_MAX stderr
    stdin stdout clearerr fclose feof ferror fflush fgetc fgetpos fgets fopen fprintf fputc fputs fread freopen fscanf
    fseek fsetpos ftell fwrite getc getchar gets perror printf putc putchar puts remove rename rewind scanf setbuf
    setvbuf snprintf sprintf sscanf tmpfile tmpnam ungetc vfprintf vfscanf vprintf vscanf vsnprintf vsprintf vsscanf
    """
)
_REST: Final = _words(
    """
    assert errno EDOM EILSEQ ERANGE abort abs atexit atof atoi atol atoll bsearch calloc div div_t exit free getenv labs
    ldiv ldiv_t llabs lldiv lldiv_t malloc mblen mbstowcs mbtowc qsort rand realloc srand strtod strtof strtol strtold
    strtoll strtoul strtoull system wcstombs wctomb EXIT_FAILURE EXIT_SUCCESS MB_CUR_MAX RAND_MAX aligned_alloc
    quick_exit at_quick_exit clock clock_t time time_t tm asctime ctime difftime gmtime localtime mktime strftime
    CLOCKS_PER_SEC jmp_buf longjmp setjmp raise signal sig_atomic_t va_arg va_copy va_end va_list va_start lconv
    localeconv setlocale feclearexcept fegetenv fegetexceptflag fegetround feholdexcept feraiseexcept fesetenv
    fesetexceptflag fesetround fetestexcept feupdateenv fenv_t fexcept_t linux unix near far interrupt main index rindex
    """
)

#: Names of the standard library, and macros of compilers.
LIBRARY: Final = _MATH | _FLOAT | _INTEGERS | _TEXT | _FILES | _REST

#: Names that a function, which the linker sees, must not have: of POSIX, of the libraries of small targets, and the
#: headers, with which its names would clash.
LINKED: Final = _of_three_types("drem finite gamma scalb significand isinf isnan j0 j1 jn y0 y1 yn") | _words(
    """
    clearerr_unlocked feof_unlocked ferror_unlocked fflush_unlocked fgetc_unlocked fileno_unlocked fputc_unlocked
    fread_unlocked fwrite_unlocked getc_unlocked getchar_unlocked putc_unlocked putchar_unlocked strcasecmp_l
    strcoll_l strerror_l strncasecmp_l strxfrm_l bcmp bcopy bzero ctermid dprintf explicit_bzero fdopen ffs ffsl
    ffsll fileno flockfile fmemopen fseeko ftello ftrylockfile funlockfile getdelim getline getw lgamma_r lgammaf_r
    lgammal_r locale_t off_t open_memstream pclose popen putw renameat setbuffer setlinebuf ssize_t stpcpy stpncpy
    strcasecmp strerror_r strncasecmp strnlen strsep strsignal strtok_r tempnam vdprintf close creat dup execve fork
    fstat getpid gettimeofday isatty kill link lseek open pipe pause poll read readv recv sbrk select send sleep
    socket stat times unlink usleep wait write writev
    assert complex ctype errno fenv float inttypes iso646 limits locale math setjmp signal stdalign stdarg stdatomic
    stdbit stdbool stdckdint stddef stdint stdio stdlib stdnoreturn string tgmath threads time uchar wchar wctype
    """
)


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

#: More names that a function must not have: names that the linker knows, and variables of the self-test.
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

#: Words of Python, and names of values of a module besides inputs.
PYTHON_RESERVED: Final = _words(
    """
    and as assert async await break case class continue def del elif else except false finally for from global
    if import in is lambda match none nonlocal not or pass raise return true try type while with yield False None True
    abs float range print sum math sys main inf nan state result divide smaller larger held power sqrt exp
    log sin cos tan atan2 floor fmod as_number evaluate init rates INPUTS OUTPUTS NoRuleFires len zip ArithmeticError
    OverflowError ValueError
    """
)

#: More names that a function must not have: variables of the function `main`, which calls it.
PYTHON_FUNCTION_RESERVED: Final = PYTHON_RESERVED | _words("arguments values value point name error")

#: Words of JavaScript in modules, and names of values of a module besides inputs.
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

#: More names that a function must not have: `then` makes a promise of a module, and the self-test has variables.
JAVASCRIPT_FUNCTION_RESERVED: Final = JAVASCRIPT_RESERVED | _words(
    "then vectors tolerance worst compare vector output round failures wanted off found refused error console process"
)

#: Names of generated text: arguments, values, tables.
_OWN: Final = re.compile(r"(r?[vstxcku]|r|rate|consequent|result|held)\d+(_.*)?$|c$", re.IGNORECASE)
#: The suffix that tells names of a rule file from those.
_SUFFIXED: Final = re.compile(r"_fz(_\d+)?$")


class Names:
    """Give out identifiers, each once.

    Greek letters are spelt out, accents dropped, and other characters outside ASCII become `uXXXX`; a name that the
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
        """Return the identifier for a name, which no other name gets.

        Args:
            name: As the rule file has it.
            apart_from: Prefixes of names of generated text.
        """
        wanted = ascii_name(name)
        while self._is_kept(wanted, apart_from):
            wanted += "_fz"
        result, number = wanted, 1
        while self._key(result) in self._taken or self._is_kept(result, apart_from):
            number += 1
            result = f"{wanted}_{number}"
        self._taken.add(self._key(result))
        return result

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
