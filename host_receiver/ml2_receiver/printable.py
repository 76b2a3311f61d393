"""Makes text of peers and files safe for terminals, tables and logs."""

# The limit of one text.
MOST_CHARACTERS = 2000


def printable(text: str, most: int = MOST_CHARACTERS, *, has_lines: bool = False) -> str:
    """Returns the text with control and other unprintable characters escaped.

    A text of more than `most` characters is cut, and then ends with `...`.

    Args:
        has_lines: True keeps line breaks.
    """
    if text.isprintable() and len(text) <= most:
        return text
    plain = "\n" if has_lines else ""
    kept = "".join(
        it if it.isprintable() or it in plain else ascii(it)[1:-1] for it in text[: most + 1]
    )
    return kept if len(kept) <= most else f"{kept[: most - 3]}..."


def markup(text: str, most: int = MOST_CHARACTERS) -> str:
    """Returns printable(text) with brackets escaped for rich."""
    from rich.markup import escape  # the driver alone needs no rich

    return escape(printable(text, most))
