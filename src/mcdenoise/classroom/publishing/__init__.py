"""Publishing: executed notebooks, and the lecture site with its slides and PDFs."""
