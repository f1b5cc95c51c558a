"""The roof: comparisons, charts, reports and benchmarks of everything below. The only room with matplotlib."""
