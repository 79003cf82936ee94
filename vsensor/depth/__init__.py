"""What the depths tell: whether the bit is off bottom, and by how many stands the string is longer."""

from vsensor.depth.depths import DEEPEST_M, MOST_STANDS, SLACK_M, Depths

__all__ = ["DEEPEST_M", "MOST_STANDS", "SLACK_M", "Depths"]
