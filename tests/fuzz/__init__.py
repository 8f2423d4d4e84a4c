"""Hostile arguments for every public function, in processes with limits.

Calls are lines of Python, made from a seed and the signatures, so that whatever fails is printed as
a line that anybody can run. ``python -m fuzz --calls 1000000`` (from `tests`) runs many.
"""
