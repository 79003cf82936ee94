"""Benchmarks: speed, throughput and lateness, each measured beside its yardstick in the same run."""
