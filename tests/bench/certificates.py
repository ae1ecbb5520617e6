"""Re-check the proved claims of loops by the checker, and print a table of them.

python tests/bench/certificates.py [FILE...]: without a file those of the gallery and of rules/loops.
Each file is proved, and its certificate is verified by a checker alone in a folder, in a Python without packages.
"""

import json
import resource
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).parents[2]
#: Seconds for each claim.
TIMEOUT = "100"


def seconds(*command):
    """Run a command; return its processor time [s], its exit code and its output."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=ROOT)
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before, done.returncode, done.stdout


def row(file, folder):
    """Return the row of a file: claims of its loops, and how many are proved, certified and verified; None for none."""
    path = folder / "c.json"
    path.unlink(missing_ok=True)
    options = ["--timeout", TIMEOUT, "--certificate", str(path), "--format", "json"]
    wrote, _, printed = seconds(sys.executable, "-m", "fuzzyctl", "prove", str(file), *options)
    data = json.loads(printed)
    claims = [g["verdict"] for loop in data.get("loops", ()) for g in loop["guarantees"]]
    if not claims:
        return None
    lines = [line for part in json.loads(path.read_text())["parts"] for line in part["lines"]] if path.exists() else []
    checked, code, said = (
        seconds(sys.executable, "-I", "-S", str(folder / "verify.py"), str(path)) if lines else (0, 1, "")
    )
    counts = [len(claims), claims.count("proved"), len(lines), 0 if code else len(lines)]
    if lines and not code:
        assert all(f"verified: {line.removeprefix('require ')[:99]}" in said for line in lines)
    size = f"{path.stat().st_size / 1000:.0f}" if lines else ""
    reasons = "; ".join(dict.fromkeys(data["certificate"]["without"].values()))
    return [file.stem, *counts, size, f"{wrote:.1f}", f"{checked:.2f}" if lines else "", reasons]


def main(files):
    """Print a row for each file, and their sum."""
    total = [0] * 4
    print("| file | claims | proved | certified | verified | kB | prove [s] | verify [s] | without, because |")
    print("|---" * 9 + "|")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for source in ("verify.py", "verify_numbers.py"):
            shutil.copy(ROOT / "fuzzyctl" / "analysis" / source, folder)
        for file in files:
            if cells := row(file, folder):
                total = [a + b for a, b in zip(total, cells[1:5], strict=True)]
                print("|", " | ".join(map(str, cells)), "|", flush=True)
    print("| all |", " | ".join(map(str, total)), "| | | | |")


if __name__ == "__main__":
    shipped = sorted((ROOT / "apps" / "gallery").glob("*/*.fz")) + sorted((ROOT / "rules" / "loops").glob("*.fz"))
    main([Path(a).resolve() for a in sys.argv[1:]] or [f for f in shipped if "require " in f.read_text()])
