"""Energies of snow that flows, learned from its return map (after Li et al. 2022, "PlasticityNet")."""
