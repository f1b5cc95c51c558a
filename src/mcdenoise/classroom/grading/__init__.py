"""Grading: answers run in child processes behind a sandbox; points, tables and feedback stay on this side."""
