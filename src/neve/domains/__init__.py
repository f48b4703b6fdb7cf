"""One run in several domains, each with particles and a grid of its own, which meet at their borders.

`partition` says which domain owns a block, `halo` which blocks of nodes several domains have, and
`transport` is how domains tell each other of them. Nothing here knows what a domain is computed on.
"""
