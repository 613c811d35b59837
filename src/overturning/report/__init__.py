"""The report of a study: a list of sections, built once from the results, and two renderers of it, HTML and PDF.

`report.sections` says what the report says, `report.build` lists it, `report.blocks` is what it is made of;
`report.html` and `report.pdf` lay it out and hold no words of their own.
"""
