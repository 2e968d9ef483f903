"""The map of arXiv 2404.19407: each of its statements with the function, the test and the section that holds it.

``python -m tools.paper_map`` (``make paper-map``) writes ``docs/paper.md`` from these tables.
"""
