"""Parts of the kernels that tests call, compiled and kept in the package's cache of compiled kernels.

Their folder in the cache is named after a digest of all files of this folder and of all that is compiled into the
kernels. A function that contains a large part of a kernel belongs here: elsewhere every run of the tests compiles it.
"""
