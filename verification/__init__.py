"""What checks the kernel, apart from any study: how exact, how fast, where it ends, against peers and theory.

Every part is run as ``python -m verification.<part>`` in the project's folder and puts its tables between marks of the
docs.
"""
