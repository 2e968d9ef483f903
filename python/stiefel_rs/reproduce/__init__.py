"""``stiefel-rs reproduce``: recomputes the comparison of arXiv 2404.19407, with its tables and figures.

Importing this package imports nothing else: the modules that draw (`figures`, and those whose names end in ``_figure``)
import matplotlib, the others do not.
"""
