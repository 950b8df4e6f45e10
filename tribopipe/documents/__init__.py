"""What people write: runs, recipes, studies, plans, with units and uncertainties.

Imports ``base``, and of ``physics`` the names in ``physics.calculation_methods``.
"""
