"""Files shipped with the package, found in a wheel and in an editable install alike."""

from __future__ import annotations

from pathlib import Path


def rules_folder() -> Path:
    """Return the folder of the shipped rule files.

    Raises:
        FileNotFoundError: When the installation is not whole.
    """
    package = Path(__file__).resolve().parents[1]
    for folder in (package / "rules", package.parent / "rules"):
        if folder.is_dir():
            return folder
    raise FileNotFoundError(f"the rule files are missing from the installation at {package}")


def explanations_folder() -> Path | None:
    """Return the folder of the pages that explain diagnostic codes, or None when the installation has none."""
    package = Path(__file__).resolve().parents[1]
    folders = (package / "explanations", package.parent / "docs" / "reference" / "diagnostics")
    return next((folder for folder in folders if folder.is_dir()), None)
