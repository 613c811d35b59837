"""Compiled functions of tests, kept in the package's cache of compiled kernels (`cache_compiled_kernel`).

Its folder for them is named after a digest of all files of this folder and of all that is compiled into the kernels.
Compiled functions that tests share, or that contain a large part of a kernel, belong here: elsewhere every run of the
tests compiles them.
"""
