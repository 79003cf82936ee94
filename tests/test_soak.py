"""Some seconds of random faults: the books balance."""

import random
from pathlib import Path

import pytest

from tests.rigs import SHORT
from tests.soak import soak


@pytest.mark.process
def test_after_random_faults_the_books_balance(tmp_path: Path) -> None:
    seed = random.SystemRandom().randrange(10**6)
    said: list[str] = [f"seed {seed}"]
    assert soak(SHORT, 8.0, seed, tmp_path, said.append) == [], "\n".join(said)
