"""The figures of the lecture, one module a chapter: `python -m mcdenoise.study.figures ch02` makes those of chapter 02.

Each chapter's module has a dict ``FIGURES``: name -> function without arguments that returns (picture, numbers). The
picture is a matplotlib Figure (stored as a PNG) or a Slider (stored as an HTML fragment); the numbers are a dict of
everything the text may quote, stored in one JSON file a chapter.
"""
