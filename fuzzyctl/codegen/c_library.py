"""Reserved identifiers of the C standard library (C99, with what C11 and C23 add), header by header.

Macros replace a name wherever it stands, so no name of a file may be one, those of members included. The compiler's own
mode adds names of POSIX to the headers that generated code includes.
"""

from __future__ import annotations

from typing import Final


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
#: headers, beside which its own would stand.
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
