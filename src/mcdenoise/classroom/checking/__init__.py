"""Checking: what an exercise is, how an answer is taken from a notebook, called, and described in words."""
