"""Words of a file that somebody else made, fit for a terminal, which would obey some letters."""


def printable(text: str) -> str:
    """The text with what cannot be printed, such as an escape, written out (\\x1b)."""
    return "".join(letter if letter.isprintable() else repr(letter)[1:-1] for letter in text)
