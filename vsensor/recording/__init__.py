"""Sessions in MCAP: written beside the loop, read back, mended, played and verified."""
