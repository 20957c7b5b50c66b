"""Text of the user's own where it could mean something else: in pictures and spreadsheets."""

FORMULA = ("=", "+", "-", "@", "\t", "\r")


def for_picture(text: str) -> str:
    """The text as Matplotlib shows it: no formula between dollars, no label that is hidden because
    it begins with an underscore."""
    shown = text.replace("$", r"\$")
    return f" {shown}" if shown.startswith("_") else shown


def for_spreadsheets(text: str) -> str:
    """The text as a cell of a CSV file that no spreadsheet takes for a formula; numbers stay."""
    return f"'{text}" if text.startswith(FORMULA) and not _is_number(text) else text


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True
