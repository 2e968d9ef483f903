"""Write the page."""

from .page import PAGE, text

PAGE.write_text(text(), encoding="utf-8")
