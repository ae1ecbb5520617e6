"""The same watch as fuzz_language.py, guided by coverage. Needs atheris, which is no dependency of the project:

pip install atheris
python tests/fuzz/fuzz_atheris.py -runs=100000 -max_len=4096
"""

import sys

import atheris

with atheris.instrument_imports(include=["fuzzyctl"]):
    from fuzz_language import one


def try_one(data):
    one(data.decode("latin-1"))


if __name__ == "__main__":
    atheris.Setup(sys.argv, try_one)
    atheris.Fuzz()
