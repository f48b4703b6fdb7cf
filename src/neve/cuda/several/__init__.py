"""One run on several GPUs: each has the particles of a domain, and halos of nodes go between them.

A static partition into slabs, as in Wang et al. 2020; how the domains speak is `neve.domains.transport`.
"""
