"""Sizes of certificates, and the processor time to write and to verify them.

python tests/bench/certificates.py [FILE...]: without a file the loops of the ARCH competition and `upright`.
"""

import resource
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).parents[2]


def seconds(*command):
    """Run a command; return its processor time [s] and its exit code."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=ROOT)
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before, done.returncode


def main(files):
    """Print a line for each file."""
    with tempfile.TemporaryDirectory() as folder:
        for file in files:
            path = Path(folder) / "c.json"
            wrote, _ = seconds(sys.executable, "-m", "fuzzyctl", "prove", str(file), "--certificate", str(path))
            checked, code = seconds(sys.executable, "-I", str(ROOT / "fuzzyctl" / "analysis" / "verify.py"), str(path))
            verdict = "verified" if code == 0 else "refused"
            size = path.stat().st_size / 1000
            print(
                f"{file.stem:14} {size:5.0f} kB  prove {wrote:5.1f} s  verify {checked:5.2f} s  {verdict}", flush=True
            )


if __name__ == "__main__":
    shipped = [*sorted((ROOT / "apps" / "gallery").glob("arch_*/*.fz")), ROOT / "rules" / "loops" / "upright.fz"]
    main([Path(a) for a in sys.argv[1:]] or shipped)
