"""Learning: populations, their bodies, and the estimators made from them.

No running site imports it.
"""
