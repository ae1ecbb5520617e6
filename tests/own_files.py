"""Files of the repository, without what package managers put between them."""

from pathlib import Path


def own_files(folder: Path, pattern: str) -> list[Path]:
    """Return the files below a folder that fit a pattern, in order; those of Node's packages are not the project's."""
    return sorted(p for p in folder.rglob(pattern) if "node_modules" not in p.parts)
