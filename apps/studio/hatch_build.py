"""Builds the studio's folder when pip builds the package `fuzzyctl-studio`."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface


class FolderHook(BuildHookInterface):
    """Puts the folder into wheels as the package `fuzzyctl_studio`, and into source distributions as it is."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Build the folder if this is a checkout with npm; else take the one that is there."""
        root = Path(self.root)
        npm = shutil.which("npm")
        if npm and (root.parents[1] / "fuzzyctl" / "__init__.py").is_file():
            for command in ([npm, "ci", "--ignore-scripts", "--engine-strict"], ["node", "build.mjs"]):
                if subprocess.run(command, cwd=root, env={**os.environ, "PYTHON": sys.executable}).returncode:
                    self.app.abort(f"the studio cannot be built: '{' '.join(command)}' fails in {root}, see above")
        elif not (root / "dist" / "index.html").is_file():
            self.app.abort("the studio cannot be built: there is no npm; install Node 20 or newer, and try again")
        folder = {str(root / "dist"): "fuzzyctl_studio" if self.target_name == "wheel" else "dist"}
        build_data["force_include"] |= folder
        build_data["force_include_editable"] = folder
