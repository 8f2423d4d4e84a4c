"""The same bits on every processor: numbers made once, results of every verb, and their comparison.

`make test-aarch64` runs it: here at every level of instructions, and on an emulated aarch64. What
two processors may not share is in the inputs: NumPy's own sines and sums differ between them, so
inputs are made once and read by all. On the others it needs nothing but NumPy and spheremap.
"""
