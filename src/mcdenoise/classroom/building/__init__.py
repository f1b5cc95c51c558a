"""Building: from notebooks and tests to what students get, to nbgrader's course, and to archives without leaks."""
