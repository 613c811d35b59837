"""Independent references for the kernels: plain loops, compiled and kept in the package's cache of compiled kernels.

Their folder in the cache is named after a digest of all files of this folder and of all that is compiled into the
kernels.
"""
