"""Text of others, made fit for terminals, tables and logs."""

# Of one text, whatever a file or a peer puts into it.
MOST_CHARACTERS = 2000


def printable(text: str, most: int = MOST_CHARACTERS, *, has_lines: bool = False) -> str:
    """Returns the text with escapes for what moves a cursor or does more to a terminal.

    More than `most` characters are cut off, which `...` then says.

    Args:
        has_lines: line breaks stay.
    """
    if text.isprintable() and len(text) <= most:
        return text
    plain = "\n" if has_lines else ""
    kept = "".join(
        it if it.isprintable() or it in plain else ascii(it)[1:-1] for it in text[: most + 1]
    )
    return kept if len(kept) <= most else f"{kept[: most - 3]}..."


def markup(text: str, most: int = MOST_CHARACTERS) -> str:
    """Returns printable(text) as markup of rich, which shows brackets as they are."""
    from rich.markup import escape  # few who need printable() show tables

    return escape(printable(text, most))
