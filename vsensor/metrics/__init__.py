"""The daemon's health for Prometheus and probes, by a process that the loop never waits for."""
