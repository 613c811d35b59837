"""Measurements of the kernels: accuracy, speed, limits, and comparisons with other engines and closed forms.

Run each part as ``python -m verification.<part>`` in the folder of the project. It writes its tables between markers in
the docs.
"""
