"""The report: what happened in a session, as one page that a person understands in ten seconds."""
