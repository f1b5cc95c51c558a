"""Numba loops: arrays and numbers only. Each kernel is the fast twin of a NumPy reference in the room that owns the
equation.

Nobody checks input here: the gate stands before every public function. All kernels work in float32, in parallel over
rows, and give the same bits at any number of threads. Importing a kernel imports numba, so the rooms do it inside their
functions.

Kernels may be called from several Python threads at once where numba has OpenMP or TBB; numba's own "workqueue" layer,
its last resort, allows one call at a time.
"""
