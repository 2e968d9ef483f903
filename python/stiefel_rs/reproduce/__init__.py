"""``stiefel-rs reproduce``: the comparison of arXiv 2404.19407 computed anew, with its tables and figures.

Importing this package imports nothing else: the modules that draw (`figures`, and those whose names end in ``_figure``)
import matplotlib, the others do not.
"""
