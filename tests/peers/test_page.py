"""docs/explanation/peers.md shows the counts of the file beside it."""

from __future__ import annotations

import json
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2]))

from tests.peers.run import rendered

PAGE = Path(__file__).parent.parent.parent / "docs" / "explanation" / "peers.md"


def test_the_table_of_the_page_is_that_of_the_runs() -> None:
    results = json.loads((PAGE.parent / "peers" / "results.json").read_text(encoding="utf-8"))
    assert rendered(results) in PAGE.read_text(encoding="utf-8")
