"""One scene over the ranks of an MPI launch: `mpirun -n 4 neve run SCENE`.

Each rank owns the particles of a piece of space and steps them with the stages of one rank; in between it is
given what homes of other ranks add to its nodes. The first rank leads: it reads the scene, gathers the
particles after each frame and writes the run folder; the others follow it.
"""
