"""Make the environments of the peers: one for each, apart from this one and from each other.

    python tests/peers/environments.py [--peer NAME] [--include DIR --library DIR]

They stand in the folder that FUZZYCTL_PEERS names, else among the temporary files. Python's peers are installed by pip,
with their versions. fuzzylite's C++ engine needs g++ and its headers and library (Debian: libfuzzylite-dev), or the
folders given. Octave needs its toolkit (Debian: octave-fuzzy-logic-toolkit) and is run where it is.
"""

from __future__ import annotations

import argparse
import shutil
import subprocess
import sys
import venv
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2]))

from tests.peers.catalogue import DRIVERS, PEERS, Peer, folder


def main() -> int:
    """Make the environments that the command line asks for."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--peer", choices=list(PEERS), action="append")
    parser.add_argument("--include", help="folder of fuzzylite's headers")
    parser.add_argument("--library", help="folder of fuzzylite's library")
    options = parser.parse_args()
    missing = 0
    for name in options.peer or list(PEERS):
        peer = PEERS[name]
        if peer.packages:
            installed(peer)
        elif peer.driver.endswith(".cpp"):
            compiled(peer, options.include, options.library)
        ready = peer.command() is not None
        missing += not ready
        print(f"{name} {peer.version}: {'ready' if ready else 'missing; see --help'}")
    return int(missing > 0)


def installed(peer: Peer) -> None:
    """Install a peer of Python's, unless it is."""
    place = folder() / peer.name
    if not (place / "bin" / "python").exists():
        venv.create(place, with_pip=True)
    subprocess.run([place / "bin" / "python", "-m", "pip", "install", "--quiet", *peer.packages], check=True)


def compiled(peer: Peer, include: str | None, library: str | None) -> None:
    """Compile the driver of fuzzylite's engine where there are a compiler and the engine."""
    compiler = shutil.which("g++")
    if compiler is None:
        return
    target = folder() / peer.name / "driver"
    target.parent.mkdir(parents=True, exist_ok=True)
    places = [f"-I{include}"] if include else []
    places += [f"-L{library}", f"-Wl,-rpath,{library}"] if library else []
    command = [compiler, "-std=c++17", "-O1", str(DRIVERS / peer.driver), *places, "-lfuzzylite", "-o", str(target)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        print(done.stderr.strip()[-400:])


if __name__ == "__main__":
    sys.exit(main())
