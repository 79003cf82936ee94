"""The command line: each command parses, calls, prints; one file a command."""
