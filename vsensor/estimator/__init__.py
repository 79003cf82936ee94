"""The virtual sensor itself: pure numbers in, pure numbers out; no clock, no files, no log."""
