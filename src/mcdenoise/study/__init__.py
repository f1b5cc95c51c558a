"""The roof: comparisons, charts, reports and benchmarks. The only room that imports matplotlib."""
