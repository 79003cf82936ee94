"""The errors that a user can mend: one tree, each with an exit status."""


class VsensorError(Exception):
    """Something that the message explains and its reader can put right; exit status 1."""

    exit_status = 1


class ConfigError(VsensorError):
    """A configuration that cannot be used; the message names the file and every faulty key."""

    exit_status = 2


class InputError(VsensorError):
    """A table or session that cannot be read; the message names the file and the place."""


class BusError(VsensorError):
    """The bus cannot be reached or refuses us; the message names the endpoint."""
